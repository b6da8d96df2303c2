"""The box of a tick as compiled functions; ``viable_bounds`` and ``jerk_bounds`` derive it."""
