"""From a scene to its program."""
