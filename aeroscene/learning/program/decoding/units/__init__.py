"""Decoding of units on covers: their places, and the members that have room."""
