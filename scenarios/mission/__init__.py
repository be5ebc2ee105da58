"""Mission through a scene: the map of the place, the areas to land on and the plan."""
