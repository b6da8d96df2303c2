"""A node's command line: what is wrong in it is one line."""

import pytest
import rclpy

from lexstack.errors import ConfigurationError
from lexstack_ros.node.spin import begin_ros, beside


@pytest.mark.parametrize(
    ("arguments", "what"),
    [
        (["node", "--ros-args", "-p", "x"], "arguments of the node: failed to initialize"),
        (["node", "--ros-args", "--nonsense"], "--nonsense"),
        (["node", "--what"], "unknown '--what'"),
    ],
)
def test_wrong_arguments_are_a_configuration_error(arguments, what):
    with pytest.raises(ConfigurationError) as error:
        begin_ros(arguments)
    assert what in str(error.value)
    assert "\n" not in str(error.value)
    assert not rclpy.ok()


def test_in_lockstep_nothing_yields_to_the_ticks():
    """They would run away from an HTMPC that the controller does not wait for."""
    assert beside("lockstep") == 0 < beside("realtime")
