"""Doctor: checks of this machine by trial, each with a remedy.

Checks do what a flight would do instead of comparing versions, because only that shows whether it
works: they open ports, take off in a scene and render an image.
"""
