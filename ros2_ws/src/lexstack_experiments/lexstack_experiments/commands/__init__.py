"""The commands ``scripts/experiment`` and ``scripts/bench``."""
