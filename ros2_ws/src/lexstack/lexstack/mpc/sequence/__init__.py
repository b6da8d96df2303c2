"""Sequences of tasks, and how one robot executes them."""
