"""The topics that a bag is read by: names alone, as a recorder needs them without a reader."""

from __future__ import annotations

PLANT_STATE = "/plant/state"
COMMAND = "/robot_a/chi"
CONTROLLERS = ("robot_a", "robot_b")  # whatever the robots are called
TRANSITION = "/robot_a/transition"
REQUEST = "/robot_a/stack_request"
DECISIONS = "/robot_a/references"
NEEDED = (PLANT_STATE, COMMAND, TRANSITION)
"""Topics without which there is nothing to analyse."""
