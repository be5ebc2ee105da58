"""Worlds as files that other programs open: MJCF for MuJoCo, GLB for viewers, USD for Isaac Sim."""
