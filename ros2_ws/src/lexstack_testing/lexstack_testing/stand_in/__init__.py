"""Robots in MuJoCo behind the topics of their controllers, with the habits of hardware."""
