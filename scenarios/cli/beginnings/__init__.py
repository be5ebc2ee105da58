"""Starter files that `aeroscene new` copies under a name that the user chooses."""
