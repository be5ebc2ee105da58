"""Doctor: checks of this machine by trial, each with a remedy."""
