"""Limits of joints, and the bounds on the commanded velocity that keep them."""
