"""Goals in words: texts that name one place of a scene, and the check that they do."""
