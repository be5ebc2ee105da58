"""Pilots of others: users' classes, and programs that fly over MAVLink."""
