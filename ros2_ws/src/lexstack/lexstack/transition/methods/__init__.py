"""The transition methods: one file each, by the name that requests use."""

from lexstack.options import register
from lexstack.transition.methods.bridging import bridge
from lexstack.transition.methods.paper import t34, t34_limited, t37
from lexstack.transition.methods.view import Levels, Method, View

METHODS: dict[str, Method] = {
    "bridge": bridge,
    "bridge_jerk": bridge,
    "t37": t37,
    "t34": t34,
    "t34_limited": t34_limited,
}
"""The first is the default, those after the second are as paper T prints them; others are added by
``register_method``."""

BRIDGES = frozenset({"bridge", "bridge_jerk"})
"""Those that fade a gap out wherever it comes from: also one that is left at the end."""

JERK_LIMITED = frozenset({"bridge_jerk"})
"""Those during which the controller's box keeps jerk limits too."""


def register_method(name: str, method: Method) -> None:
    """Make a transition method known by a name, for requests and scenarios.

    Raises:
        ConfigurationError: it is no name, or the name of another method.
    """
    register(METHODS, "method", name, method)


__all__ = ["BRIDGES", "JERK_LIMITED", "METHODS", "Levels", "Method", "View", "register_method"]
