"""Surroundings that act on a plant besides solids: rooms, steel, the lee of buildings."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from aeroscene.scene import Scene
from flightsim.environment.effects import Effects
from flightsim.environment.rooms import indoor_rooms
from flightsim.environment.shelter import Grid, blocks_of, grid_for, ground_below
from flightsim.environment.steel import steel_dipoles


@dataclass(frozen=True, eq=False)
class Surroundings:
    """Arrays of a scene that its plants share, a row for each item; see `kernel.advance`."""

    rooms: Float[np.ndarray, "n 8"]
    """Rooms without satellites and wind, `flightsim.environment.rooms`."""
    steel: Float[np.ndarray, "n 5"]
    """Steel that disturbs magnetometers, `flightsim.environment.steel`."""
    blocks: Float[np.ndarray, "n 8"]
    """Blocks that shelter from the wind, `flightsim.environment.shelter`."""
    grid: Grid
    """Grid on which the flow around blocks and over the ground is known."""
    ground_below_m: Float[np.ndarray, "nx ny"]
    """Height of the ground below the grid's columns."""
    is_sheltered: bool
    """True if blocks or hills change the wind."""

    @classmethod
    def from_scene(cls, scene: Scene, effects: Effects) -> Surroundings:
        """Return the surroundings in a scene, without those whose effect is off."""
        blocks = blocks_of(scene)[: None if effects.shelter else 0]
        grid = grid_for(scene, blocks)
        return cls(
            rooms=indoor_rooms(scene),
            steel=steel_dipoles(scene)[: None if effects.steel else 0],
            blocks=blocks,
            grid=grid,
            ground_below_m=ground_below(scene, grid),
            is_sheltered=len(blocks) > 0 or (effects.shelter and scene.relief is not None),
        )
