"""Fixtures that tests of several folders share."""

from support.in_process import run_command

__all__ = ["run_command"]
