"""Scenes to order: what is asked for, draws until it is met, scenes that a pilot does badly in."""
