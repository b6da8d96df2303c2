"""Replay: what a bag holds goes through the controllers' core again."""
