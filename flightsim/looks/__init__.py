"""How things look: a model for drawing, with tessellated shapes and painted textures."""
