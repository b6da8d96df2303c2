"""A bag of before the chi had transitions is played with the message of today."""

from __future__ import annotations

from array import array

import numpy as np
from rclpy.serialization import deserialize_message, serialize_message
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from lexstack_bag.storage.definitions import message_definition
from lexstack_bringup.bag_player import filled
from lexstack_interfaces.msg import Chi
from lexstack_ros.messages.cdr import Buffer

NAME = "lexstack_interfaces/msg/Chi"


def test_a_chi_without_transitions_has_all_else_that_it_had():
    definition = message_definition(NAME)
    old = "\n".join(
        line
        for line in definition.splitlines()
        if not line.startswith(("TransitionStatus[]", "                        # "))
    )
    assert "transitions" not in old.split("=====")[0]
    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(old, NAME))
    message = Chi(tick=7, sender="me", robots=["one", "two"], status=1, reason="ä", solve_time=0.5)
    message.header.stamp.nanosec, message.header.frame_id = 9, "world"
    message.chi, message.slacks = array("d", np.arange(3.0)), array("d", [1.0])
    data = Buffer(message).data  # ends with the length of its transitions
    recorded = store.deserialize_cdr(data[:-4], NAME)
    assert not hasattr(recorded, "transitions")
    made = filled(Chi(), recorded)
    assert made == message
    assert deserialize_message(serialize_message(made), Chi) == message
