"""Robots behind topics of their own controllers, without ROS: states in, commands out, guards."""
