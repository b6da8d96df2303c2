"""The node of the hierarchical-task MPC (htmpc)."""
