"""Wind among buildings and over hills: less in their lee, more at corners and over crests."""

from flightsim.environment.shelter.cache import cached_shelter
from flightsim.environment.shelter.shelter import (
    Grid,
    blocks_of,
    flow_at,
    grid_for,
    ground_below,
)

__all__ = ["Grid", "blocks_of", "cached_shelter", "flow_at", "grid_for", "ground_below"]
