"""Starts the processes of a run, plays its scenario, ends it."""
