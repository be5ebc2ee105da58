"""Commander, modes, navigator and failsafes: the 50 Hz half of the autopilot."""
