"""Patterns of surfaces: each turns a colour into a picture that repeats without a seam."""
