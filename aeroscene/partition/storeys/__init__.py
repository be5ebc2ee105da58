"""Rooms of a storey as a partition, with a border layer of walls, doors, windows and openings."""
