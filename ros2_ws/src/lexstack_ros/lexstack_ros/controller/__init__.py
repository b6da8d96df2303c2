"""The node of the controller (robot A)."""
