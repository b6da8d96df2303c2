"""Whose velocities a transition goes to: another solver's, or plans of the MPC."""
