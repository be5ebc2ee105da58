"""Figures about scenes: collisions, plausibility, diversity, memorisation, and places."""
