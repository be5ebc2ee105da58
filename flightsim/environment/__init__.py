"""What surrounds the vehicle: air, wind and the Earth's magnetic field."""
