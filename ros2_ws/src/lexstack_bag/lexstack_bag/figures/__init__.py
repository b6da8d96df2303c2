"""Figures of a run: errors, limits, times."""
