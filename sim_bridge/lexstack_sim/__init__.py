"""MuJoCo plant with joint impedance control, and pictures of it; without ROS."""
