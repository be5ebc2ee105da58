"""Wind among buildings: less in their lee, more at their corners."""

from flightsim.environment.shelter.kept import kept_shelter
from flightsim.environment.shelter.shelter import Grid, blocks_of, flow_at, grid_for

__all__ = ["Grid", "blocks_of", "flow_at", "grid_for", "kept_shelter"]
