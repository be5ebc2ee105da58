"""What flies the trials of a campaign: who flies which, and in which processes."""
