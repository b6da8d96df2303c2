"""Kinematics as compiled functions."""
