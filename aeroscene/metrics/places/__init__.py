"""Whether scenes are places: what meets, faces, lies on and stands along what, by geometry alone."""
