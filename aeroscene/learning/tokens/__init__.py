"""Scenes as tokens: kinds, skeletons, geometry as channels, and back."""
