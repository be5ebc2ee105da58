"""Encoding of a scene as its program."""
