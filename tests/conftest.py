"""Fixtures that tests of several folders share."""

from support.in_process import run_command
from support.registries import registries

__all__ = ["registries", "run_command"]
