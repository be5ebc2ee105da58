"""The simulated world, its vehicles, sensors and autopilot, and their MAVLink."""
