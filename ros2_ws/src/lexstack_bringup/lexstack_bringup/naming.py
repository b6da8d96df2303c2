"""Under which names the nodes of a run meet: a namespace, and roles in place of the paper's."""

from __future__ import annotations

import argparse
import re
from dataclasses import dataclass

from lexstack.errors import ConfigurationError
from lexstack.options import shown
from lexstack_bag.topics import role_names
from lexstack_ros.messages.names import relative

_PART = "[A-Za-z][A-Za-z0-9_]*"
_LONGEST = 100  # characters: of 255 that a topic's name may have


@dataclass(frozen=True, slots=True)
class Naming:
    """How names differ from those in the documents.

    Attributes:
        namespace: of all nodes, topics, services and actions, like cell1 or hall/cell1; empty:
            none. Cells of different namespaces share a domain and do not hear each other.
        roles: whether the controller's and the solver's topics are /controller/... and /solver/...
            in place of /robot_a/... and /robot_b/...
    """

    namespace: str = ""
    roles: bool = False

    @classmethod
    def of(cls, options: argparse.Namespace) -> Naming:
        """Return what ``add_naming_arguments`` has read; raises ConfigurationError."""
        namespace = options.namespace.removeprefix("/")
        fits = re.fullmatch(f"({_PART}(/{_PART})*)?", namespace) and len(namespace) <= _LONGEST
        if not fits:
            raise ConfigurationError(
                f"--namespace: expected names of letters, digits and _ with / between them, at "
                f"most {_LONGEST} characters, got {shown(options.namespace)}"
            )
        return cls(namespace, options.roles)

    @property
    def rules(self) -> list[str]:
        """The rules that ROS takes after ``--ros-args``, the same for every node of the run."""
        rules = []
        if self.namespace:
            # Simulated time is the cell's own: rclpy hears /clock, whatever the namespace.
            rules += [f"__ns:=/{self.namespace}", "/clock:=clock"]
        if self.roles:
            rules += [f"{relative(a)}:={relative(b)}" for a, b in role_names().items()]
        return [word for rule in rules for word in ("-r", rule)]


def add_naming_arguments(parser: argparse.ArgumentParser) -> None:
    """Add what says under which names a run's nodes meet."""
    parser.add_argument(
        "--namespace",
        default="",
        metavar="NAME",
        help="of all nodes and topics, such as cell1: several runs can share one ROS_DOMAIN_ID",
    )
    parser.add_argument(
        "--roles",
        action="store_true",
        help="name topics by roles, /controller/chi and /solver/chi, in place of /robot_a/chi ...",
    )
