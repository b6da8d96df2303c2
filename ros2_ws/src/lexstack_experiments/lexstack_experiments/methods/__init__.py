"""An extension: the transition methods that ours is compared with, one file each."""

from lexstack.transition import METHODS, register_method
from lexstack_experiments.methods.activation import activation
from lexstack_experiments.methods.instantly import instant, instant_limited
from lexstack_experiments.methods.interpolation import interpolation
from lexstack_experiments.methods.weights import weights

COMPARED = {
    "instant": instant,
    "instant_limited": instant_limited,
    "interpolation": interpolation,
    "activation": activation,
    "weights": weights,
}
"""By the name that requests and scenarios use."""

for _name, _method in COMPARED.items():
    register_method(_name, _method)

__all__ = ["COMPARED", "METHODS"]
