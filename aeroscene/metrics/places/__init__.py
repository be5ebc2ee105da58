"""Plausible places: checks by geometry that objects meet, face and lie where they belong."""
