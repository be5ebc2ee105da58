"""Similarity of pictures of scenes, in the view of a network that was trained on photographs."""
