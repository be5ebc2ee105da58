"""Tasks of trials: what a flight is asked to do, drawn from a recipe by number."""
