"""Appearance of the world: a model for drawing, with tessellated shapes and painted textures.

Physics and cameras have different needs, so looks are a model of their own. Dressing moves no
surface, so that depth and contacts agree.
"""
