"""Faults on purpose: a running system, what is done to it, and whether it serves again."""
