"""Commands that work on bags."""
