"""The node of the stack solver (robot B)."""
