"""The processes: one node each, without mathematics."""
