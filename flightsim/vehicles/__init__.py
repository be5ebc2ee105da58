"""Airframes, their rotor model and their battery."""
