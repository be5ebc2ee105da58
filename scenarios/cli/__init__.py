"""The commands `aeroscene-sitl` and `aeroscene`."""
