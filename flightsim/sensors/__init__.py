"""Sensors of the vehicle: inertial, GNSS, air pressure, magnetic field, range, RGB-D."""
