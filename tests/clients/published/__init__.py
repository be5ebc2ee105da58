"""A command that runs the examples that MAVSDK-Python publishes, unedited."""
