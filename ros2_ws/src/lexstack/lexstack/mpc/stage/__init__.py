"""What an iterate of the MPC costs, compiled: roll-out, kinematics, barriers, effort and tasks."""
