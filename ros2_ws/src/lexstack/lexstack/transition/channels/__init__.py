"""Channels: robots that are on one stack, or on the same way to one."""
