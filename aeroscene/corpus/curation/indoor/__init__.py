"""Indoor scenes: one building whose walls and roof bound the flight volume."""
