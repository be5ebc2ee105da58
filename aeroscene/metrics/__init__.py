"""Figures about scenes: what a corpus holds, how much its scenes differ."""
