"""Shelter that was solved before, kept in the folder `winds` of the user's cache.

A solution takes some hundredths of a second, and a campaign meets the same scene and wind many
times.
"""

from __future__ import annotations

import functools
import hashlib
from pathlib import Path

import numpy as np
from jaxtyping import Float

from aeroscene.files import cache_folder, replacing
from flightsim.environment.shelter import mass_consistent, shelter, wakes
from flightsim.environment.shelter.shelter import Grid, solve_shelter


def cached_shelter(
    grid: Grid,
    blocks: Float[np.ndarray, "n 8"],
    ground_below_m: Float[np.ndarray, "nx ny"],
    axis: tuple[float, float],
) -> Float[np.ndarray, "nx ny nz 3"]:
    """Return `solve_shelter` of a scene and a direction, solved once.

    Args:
        grid: Grid over the scene.
        blocks: Rows of `BLOCK_COLUMNS`.
        ground_below_m: Height of the ground below each column.
        axis: Horizontal unit vector along which the wind blows.
    """
    folder = cache_folder("winds")
    if folder is None:
        return solve_shelter(grid, blocks, ground_below_m, axis)
    path = folder / f"{_key(grid, blocks, ground_below_m, axis)}.npy"
    try:
        field = np.load(path, allow_pickle=False)
        if field.shape == (*grid.shape, 3):
            return field
    except (OSError, ValueError, EOFError):
        pass  # not there, or incomplete
    field = solve_shelter(grid, blocks, ground_below_m, axis)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        # Written under another name and renamed: several processes may solve the same field.
        with replacing(path) as file:
            np.save(file, field, allow_pickle=False)
    except OSError:
        pass  # a cache that cannot be written does no harm
    return field


def _key(
    grid: Grid, blocks: np.ndarray, ground_below_m: np.ndarray, axis: tuple[float, float]
) -> str:
    # The code belongs to the key, so that a changed model never reads an old field.
    digest = hashlib.blake2b(_code(), digest_size=16)
    for numbers in (grid.origin_enu_m, grid.shape, (grid.cell_m, *axis), blocks, ground_below_m):
        digest.update(np.array(numbers, dtype=float).tobytes())
    return digest.hexdigest()


@functools.cache
def _code() -> bytes:
    """Return the sources of the modules that a field follows from."""
    return b"".join(Path(str(m.__file__)).read_bytes() for m in (mass_consistent, shelter, wakes))
