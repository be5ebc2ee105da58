"""Shelter that was solved before, in the folder `winds` of the user's cache."""

from __future__ import annotations

import functools
import hashlib
from pathlib import Path

import numpy as np
from jaxtyping import Float

from aeroscene.files import cache_folder, replacing
from flightsim.environment.shelter import mass_consistent, shelter, wakes
from flightsim.environment.shelter.shelter import Grid, solve_shelter


def kept_shelter(
    grid: Grid,
    blocks: Float[np.ndarray, "n 8"],
    ground_below_m: Float[np.ndarray, "nx ny"],
    axis: tuple[float, float],
) -> Float[np.ndarray, "nx ny nz 3"]:
    """`solve_shelter` of a scene and a direction, solved once."""
    folder = cache_folder("winds")
    if folder is None:
        return solve_shelter(grid, blocks, ground_below_m, axis)
    path = folder / f"{_key(grid, blocks, ground_below_m, axis)}.npy"
    try:
        field = np.load(path, allow_pickle=False)
        if field.shape == (*grid.shape, 3):
            return field
    except (OSError, ValueError, EOFError):
        pass  # not there, or not whole
    field = solve_shelter(grid, blocks, ground_below_m, axis)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with replacing(path) as file:
            np.save(file, field, allow_pickle=False)
    except OSError:
        pass  # a cache that cannot be written does no harm
    return field


def _key(
    grid: Grid, blocks: np.ndarray, ground_below_m: np.ndarray, axis: tuple[float, float]
) -> str:
    digest = hashlib.blake2b(_code(), digest_size=16)
    for numbers in (grid.origin_enu_m, grid.shape, (grid.cell_m, *axis), blocks, ground_below_m):
        digest.update(np.array(numbers, dtype=float).tobytes())
    return digest.hexdigest()


@functools.cache
def _code() -> bytes:
    """Source of what a field follows from."""
    return b"".join(Path(str(m.__file__)).read_bytes() for m in (mass_consistent, shelter, wakes))
