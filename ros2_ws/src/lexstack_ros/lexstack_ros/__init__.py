"""ROS 2 nodes of lexstack: the seam between messages and the library."""
