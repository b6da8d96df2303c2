"""Channels: robots that share a stack, or switch to one together."""
