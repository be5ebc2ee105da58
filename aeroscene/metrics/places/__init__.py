"""Whether scenes are places: what meets, faces, lies on and lines what, by geometry alone."""
