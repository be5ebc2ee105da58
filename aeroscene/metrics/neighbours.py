"""Neighbours of objects and their relations: the displacement r_ij of the paper, in bins.

Of every object the eight nearest others, by their centres. The displacement is seen from the first:
how far in the plane, in which direction from its heading, how much higher. Bins are narrow near it,
so that a chair in line with its desk and a cup level with its table are told from almost so.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Int

from aeroscene.metrics.arrays import SceneArrays

N_NEIGHBOURS = 8
DISTANCE_EDGES_M = np.array([0.1, 0.2, 0.4, 0.7, 1.2, 2.0, 3.5, 6.0])
HEIGHT_EDGES_M = np.array([-1.0, -0.3, -0.05, 0.05, 0.3, 1.0])
N_DIRECTIONS = 8

N_DISTANCES = len(DISTANCE_EDGES_M) + 1
N_HEIGHTS = len(HEIGHT_EDGES_M) + 1
N_PLACES = N_DISTANCES * N_HEIGHTS * N_DIRECTIONS


@dataclass(frozen=True, slots=True, eq=False)
class Neighbours:
    """Ordered pairs of neighbours, of each object as many."""

    first: Int[np.ndarray, " k"]
    """Row of the object whose neighbour it is."""
    second: Int[np.ndarray, " k"]
    distance: Int[np.ndarray, " k"]
    """Bin of the displacement's length in the plane."""
    height: Int[np.ndarray, " k"]
    direction: Int[np.ndarray, " k"]
    """Sector as seen from the first: 0 is straight ahead, counter-clockwise."""

    @property
    def place(self) -> Int[np.ndarray, " k"]:
        """All three bins in one number below `N_PLACES`."""
        return (self.distance * N_HEIGHTS + self.height) * N_DIRECTIONS + self.direction


def neighbours_of(arrays: SceneArrays) -> Neighbours:
    """The nearest neighbours of every object of a scene."""
    first, second = _nearest(arrays.centre_enu_m)
    displacement_m = arrays.centre_enu_m[second] - arrays.centre_enu_m[first]
    east, north, up = displacement_m.T
    turn = (np.arctan2(north, east) - arrays.yaw_rad[first]) / (2.0 * np.pi)
    return Neighbours(
        first=first,
        second=second,
        distance=np.searchsorted(DISTANCE_EDGES_M, np.hypot(east, north)),
        height=np.searchsorted(HEIGHT_EDGES_M, up),
        direction=np.floor(turn * N_DIRECTIONS + 0.5).astype(int) % N_DIRECTIONS,
    )


def _nearest(centres: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    count = min(N_NEIGHBOURS, len(centres) - 1)
    if count < 1:
        return np.empty(0, dtype=int), np.empty(0, dtype=int)
    square = (centres**2).sum(axis=1)
    apart = square[:, None] + square - 2.0 * centres @ centres.T
    np.fill_diagonal(apart, np.inf)
    # The place in the scene breaks ties.
    second = np.argsort(apart, axis=1, kind="stable")[:, :count]
    return np.repeat(np.arange(len(centres)), count), second.ravel()
