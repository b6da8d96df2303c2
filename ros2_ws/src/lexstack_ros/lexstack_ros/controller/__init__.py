"""The node of the controller (T: robot A)."""
