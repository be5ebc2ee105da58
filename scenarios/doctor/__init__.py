"""What this machine can do: checks that really do it, each with the way out."""
