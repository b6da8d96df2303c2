"""Robots as hardware has them, in MuJoCo: topics of controllers, and habits that simulators lack."""
