"""A door for AirSim's clients: its MessagePack-RPC for multirotors, over what a run has anyway."""
