"""A MAVLink client for companions: commands, setpoints and telemetry in ENU."""
