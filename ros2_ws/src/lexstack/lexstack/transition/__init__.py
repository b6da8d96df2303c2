"""Transitions: how robot A goes from its own optimum to a source's, within limits."""
