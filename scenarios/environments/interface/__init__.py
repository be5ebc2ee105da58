"""Between agent and vehicle: actions to setpoints, states and sensors to observations."""
