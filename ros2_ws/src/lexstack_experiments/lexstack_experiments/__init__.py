"""Experiments with library and plant in one process; without rclpy."""
