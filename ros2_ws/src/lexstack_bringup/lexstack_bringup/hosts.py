"""The schema of ``config/hosts/*.yaml``: which node runs on which host, and how they meet."""

from __future__ import annotations

import ipaddress
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from lexstack.errors import ConfigurationError
from lexstack.options import NotEmpty, Positive, Range, shown
from lexstack_config.reader import build, read_yaml
from lexstack_ros.messages.names import base_of

SERVER = "discovery_server"
_LAST_DOMAIN = 232
_LAST_PORT = 65535
# What decides who finds whom; a user's own values must not mix with the file's.
VARIABLES = (
    "ROS_DOMAIN_ID",
    "ROS_AUTOMATIC_DISCOVERY_RANGE",
    "ROS_STATIC_PEERS",
    "ROS_DISCOVERY_SERVER",
    "ROS_SUPER_CLIENT",
)


@dataclass(frozen=True, slots=True)
class HostConfig:
    """One computer."""

    address: str  # IP address by which the others reach it
    nodes: Annotated[  # what runs there
        tuple[str, ...], NotEmpty("at least one node is needed")
    ]

    def validate(self, where: str) -> None:
        """Raise ConfigurationError for an address that is none."""
        try:
            ipaddress.ip_address(self.address)
        except ValueError as error:
            raise ConfigurationError(
                f"{where}: address: expected an IP address, got {self.address!r}"
            ) from error


@dataclass(frozen=True, slots=True)
class HostsConfig:
    """All hosts of a run; every host reads the same file."""

    name: str  # of the file
    description: str  # in a sentence
    domain: Annotated[int, Range(0, _LAST_DOMAIN)]  # ROS_DOMAIN_ID
    discovery: Literal["multicast", "peers", "server"]  # how nodes find each other
    hosts: dict[str, HostConfig]  # by name
    # UDP, where the discovery server listens
    server_port: Annotated[int, Range(0, _LAST_PORT)] = 11811
    wait: Positive = 60.0  # s of wall time for all nodes of all hosts to be connected

    def validate(self, where: str) -> None:
        """Raise ConfigurationError for a node that runs twice."""
        nodes = self.nodes
        twice = [node for node in dict.fromkeys(nodes) if nodes.count(node) > 1]
        if twice:
            raise ConfigurationError(f"{where}: hosts: {twice[0]} runs on more than one host")
        if (SERVER in nodes) != (self.discovery == "server"):
            raise ConfigurationError(
                f"{where}: hosts: discovery 'server' needs the node {SERVER}, others have none"
            )

    @property
    def nodes(self) -> list[str]:
        """Every node of every host."""
        return [node for host in self.hosts.values() for node in host.nodes]

    def share(self, only: Sequence[str]) -> str:
        """Return the name of the host that all the named nodes belong to.

        Raises:
            ConfigurationError: a node is unknown, or they belong to several hosts.
        """
        for node in only:
            if node not in self.nodes:
                known = ", ".join(self.nodes)
                raise ConfigurationError(f"--only: unknown node {shown(node)}; known: {known}")
        names = [name for name, host in self.hosts.items() if set(host.nodes) & set(only)]
        if len(names) != 1:
            where = ", ".join(names) or "no host"
            raise ConfigurationError(f"--only: the nodes of one host are needed, got {where}")
        return names[0]

    def needed(self, wanted: Sequence[str], scenario: str) -> list[str]:
        """Return the nodes of all hosts that a scenario needs, and the discovery server.

        Raises:
            ConfigurationError: one of them runs on no host.
        """
        absent = [node for node in wanted if node not in self.nodes]
        if absent:
            raise ConfigurationError(
                f"{self.name}: hosts: {absent[0]} runs on no host, but scenario {scenario} needs it"
            )
        return [node for node in self.nodes if node in wanted or node == SERVER]

    def environment(self, name: str) -> dict[str, str]:
        """Return the variables by which the nodes of a host find the others."""
        common = {"ROS_DOMAIN_ID": str(self.domain)}
        if self.discovery == "multicast":
            return common | {"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"}
        if self.discovery == "peers":
            others = [host.address for other, host in self.hosts.items() if other != name]
            return common | {
                "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
                "ROS_STATIC_PEERS": ";".join(others),
            }
        address = next(host.address for host in self.hosts.values() if SERVER in host.nodes)
        return common | {
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "SYSTEM_DEFAULT",
            "ROS_DISCOVERY_SERVER": f"{address}:{self.server_port}",
            # A plain client learns of the topics that it shares alone; the recorder and the
            # readiness check look at all.
            "ROS_SUPER_CLIENT": "TRUE",
        }


def load_hosts(path: Path, known: Sequence[str]) -> HostsConfig:
    """Return one file of ``config/hosts``, whose nodes are all ``known``.

    Raises:
        ConfigurationError: it is missing or wrong; the text names the file and the key.
    """
    config = build(HostsConfig, read_yaml(path), str(path))
    for node in config.nodes:
        if base_of(node) not in known:
            raise ConfigurationError(
                f"{path}: hosts: unknown node {node!r}; known: {', '.join(known)}"
            )
    return config
