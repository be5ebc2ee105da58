"""Wishes of testers that change a scene before, or judge it after, the projection."""
