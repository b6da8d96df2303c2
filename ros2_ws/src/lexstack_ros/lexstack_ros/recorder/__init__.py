"""The node that records every topic into one bag."""
