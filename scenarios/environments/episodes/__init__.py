"""Episodes: their places, their beginnings, and the verdicts at their ends."""
