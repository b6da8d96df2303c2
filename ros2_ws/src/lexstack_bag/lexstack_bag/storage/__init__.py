"""Bags as files: MCAP containers, metadata, messages."""
