"""MuJoCo plant with joint impedance control, and its ROS 2 node."""
