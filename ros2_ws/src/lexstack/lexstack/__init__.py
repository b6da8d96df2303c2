"""Hierarchical QP control, stack transitions and robot models; without ROS."""
