"""A scene and its vehicles as one MuJoCo world: model, geoms, rays, places to start from."""

from flightsim.world.world import (
    FIRST_MATE_ID,
    FIRST_MOVER_ID,
    GROUND_ID,
    GROUND_NAME,
    NEIGHBOUR_ID,
    VEHICLE_ID,
    World,
    WorldError,
    build_world,
    new_spec,
)

__all__ = [
    "FIRST_MATE_ID",
    "FIRST_MOVER_ID",
    "GROUND_ID",
    "GROUND_NAME",
    "NEIGHBOUR_ID",
    "VEHICLE_ID",
    "World",
    "WorldError",
    "build_world",
    "new_spec",
]
