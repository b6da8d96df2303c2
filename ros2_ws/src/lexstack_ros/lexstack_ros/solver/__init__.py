"""The node of the stack solver (T: robot B)."""
