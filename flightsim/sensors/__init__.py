"""What the vehicle senses: inertial, GNSS, air pressure, magnetic field, range, RGB-D."""
