"""A mission through a scene: what is known of the place, the areas to land on, the plan."""
