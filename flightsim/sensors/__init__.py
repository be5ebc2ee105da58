"""Sensors that the compiled plant reads: inertial, GNSS, pressure, magnetic field, range and flow.

Each sensor is one module that ends in a `Sensor` (see `flightsim.sensors.sensor`). A sensor is a
function of the true state and of random numbers that are handed to it. It therefore runs inside the
compiled kernel, and the same seed gives the same errors. Cameras and lidars are not here, because
they look at the world from outside of the kernel.
"""
