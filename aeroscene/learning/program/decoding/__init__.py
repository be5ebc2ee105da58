"""Decoding of a program to its scene."""
