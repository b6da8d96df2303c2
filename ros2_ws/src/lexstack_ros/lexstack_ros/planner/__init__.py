"""The node of the sequential-task MPC."""
