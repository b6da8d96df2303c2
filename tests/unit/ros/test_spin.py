"""A node's command line: what is wrong in it is one line."""

import pytest
import rclpy

from lexstack_core.errors import ConfigurationError
from lexstack_ros.spin import begin_ros


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
