"""Replay: what a bag holds goes through the nodes' library code again."""
