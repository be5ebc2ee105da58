"""Pictures of scenes while they are generated."""
