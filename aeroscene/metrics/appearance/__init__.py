"""How alike pictures of scenes look to a network that was trained on photographs."""
