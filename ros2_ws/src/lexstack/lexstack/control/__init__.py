"""The controller and the stack solver: one tick of each, as a library call."""
