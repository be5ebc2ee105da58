"""The writer: the model that draws the discrete part of programs, token by token."""
