"""Pilots that are not ours: users' classes, and programs that fly over MAVLink."""
