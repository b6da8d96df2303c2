"""The ROS side of a plant: state out, command in, once a tick."""
