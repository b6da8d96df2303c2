"""The page itself, on viser: knows pictures and orders, no ROS."""
