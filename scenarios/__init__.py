"""Tasks, trials, recordings and the command line."""
