"""Files to begin with, which `aeroscene new` copies under a name of the user's."""
