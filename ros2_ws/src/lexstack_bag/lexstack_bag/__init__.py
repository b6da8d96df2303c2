"""Run recordings: rosbag2 MCAP files, metrics and reports; without rclpy."""
