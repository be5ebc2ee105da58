"""Wishes of testers that change a scene before the projection, or judge it afterwards."""
