"""Plants: one module each."""
