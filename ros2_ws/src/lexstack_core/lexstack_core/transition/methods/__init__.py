"""The transition methods: one file each, registered here by the name that requests use."""

from lexstack_core.transition.methods.activation import activation
from lexstack_core.transition.methods.bridging import bridge
from lexstack_core.transition.methods.instantly import instant, instant_limited
from lexstack_core.transition.methods.interpolation import interpolation
from lexstack_core.transition.methods.paper import t34, t37
from lexstack_core.transition.methods.view import Levels, Method, View
from lexstack_core.transition.methods.weights import weights

METHODS: dict[str, Method] = {
    "bridge": bridge,
    "t37": t37,
    "t34": t34,
    "instant": instant,
    "instant_limited": instant_limited,
    "interpolation": interpolation,
    "activation": activation,
    "weights": weights,
}
"""The first is the default; the others are there to compare with."""

__all__ = ["METHODS", "Levels", "Method", "View"]
