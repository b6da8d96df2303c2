"""The commands that need ROS; each is a module that scripts/ calls."""
