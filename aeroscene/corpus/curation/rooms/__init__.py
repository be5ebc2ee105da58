"""Kinds of rooms: which furniture stands where, and what lies on it."""
