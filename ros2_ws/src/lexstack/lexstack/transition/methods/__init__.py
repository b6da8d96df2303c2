"""The transition methods: one file each, registered here by the name that requests use."""

from lexstack.transition.methods.activation import activation
from lexstack.transition.methods.bridging import bridge
from lexstack.transition.methods.instantly import instant, instant_limited
from lexstack.transition.methods.interpolation import interpolation
from lexstack.transition.methods.paper import t34, t34_limited, t37
from lexstack.transition.methods.view import Levels, Method, View
from lexstack.transition.methods.weights import weights

METHODS: dict[str, Method] = {
    "bridge": bridge,
    "bridge_jerk": bridge,
    "t37": t37,
    "t34": t34,
    "t34_limited": t34_limited,
    "instant": instant,
    "instant_limited": instant_limited,
    "interpolation": interpolation,
    "activation": activation,
    "weights": weights,
}
"""The first is the default; the others are there to compare with."""

BRIDGES = frozenset({"bridge", "bridge_jerk"})
"""Those that fade a gap out wherever it comes from: also one that is left at the end."""

JERK_LIMITED = frozenset({"bridge_jerk"})
"""Those during which the controller's box keeps jerk limits too."""

__all__ = ["BRIDGES", "JERK_LIMITED", "METHODS", "Levels", "Method", "View"]
