"""The writer: the autoregressive model that draws the discrete part of programs, token by token."""
