"""Kinds of places: one file each, first the structures, then the details."""
