"""Appearance of the world: a model for drawing, with tessellated shapes and painted textures."""
