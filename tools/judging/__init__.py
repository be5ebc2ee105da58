"""A second judge of flights, which knows recordings alone and nothing of the first."""
