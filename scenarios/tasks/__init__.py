"""Tasks of trials: goals and conditions of flights, drawn from a recipe by number."""
