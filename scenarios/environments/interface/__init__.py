"""Between agent and vehicle: actions to set points, states and sensors to observations."""
