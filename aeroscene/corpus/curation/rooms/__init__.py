"""Kinds of rooms: the furniture of each, its places, and the objects on it."""
