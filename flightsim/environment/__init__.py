"""Environment of the vehicle: air, wind, traffic and the Earth's magnetic field."""
