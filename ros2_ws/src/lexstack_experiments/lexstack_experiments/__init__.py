"""Experiments with core and plant in one process; without rclpy."""
