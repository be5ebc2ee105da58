"""What stands on covers: where a unit goes, and what of it has room."""
