"""Neighbours of objects and their relations: the displacement r_ij of the paper, in bins.

Each object has its eight nearest others, by their centres. The displacement is seen from the
object: distance in the plane, direction from its heading, and height. Bins are narrow near it, so
that a chair in line with its desk and a cup level with its table differ from those that are almost
so.

Invisible differences are removed. An object that looks the same after half a turn has two
equivalent headings, and the choice is the data set's: walls of the corpus face either way, those of
3D-FRONT outwards. If one centre is on top of another, as a room's and its roof's, the direction is
only rounding.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Int

from aeroscene.metrics.arrays import SceneArrays
from aeroscene.scene.catalogue import CATALOGUE, TWO_SIDED

N_NEIGHBOURS = 8
DISTANCE_EDGES_M = np.array([0.1, 0.2, 0.4, 0.7, 1.2, 2.0, 3.5, 6.0])
HEIGHT_EDGES_M = np.array([-1.0, -0.3, -0.05, 0.05, 0.3, 1.0])
N_DIRECTIONS = 8

N_DISTANCES = len(DISTANCE_EDGES_M) + 1
N_HEIGHTS = len(HEIGHT_EDGES_M) + 1
N_PLACES = N_DISTANCES * N_HEIGHTS * N_DIRECTIONS

_IS_TWO_SIDED = np.array([CATALOGUE[i].name in TWO_SIDED for i in sorted(CATALOGUE)])
_HALF = N_DIRECTIONS // 2
_ON_TOP_M = 0.01
"""Distance in the plane below which one centre is on top of the other; it then counts as ahead."""


@dataclass(frozen=True, slots=True, eq=False)
class Neighbours:
    """Ordered pairs of neighbours, equally many for each object."""

    first: Int[np.ndarray, " k"]
    """Row of the object that has the neighbour."""
    second: Int[np.ndarray, " k"]
    """Row of the neighbour."""
    distance: Int[np.ndarray, " k"]
    """Bin of the displacement's length in the plane."""
    height: Int[np.ndarray, " k"]
    """Bin of its height above the first."""
    direction: Int[np.ndarray, " k"]
    """Sector of the second as seen from the first: 0 is straight ahead, counter-clockwise."""
    heading: Int[np.ndarray, " k"]
    """Sector of the second's heading as seen from the first."""

    @property
    def place(self) -> Int[np.ndarray, " k"]:
        """All three bins in one number below `N_PLACES`."""
        return (self.distance * N_HEIGHTS + self.height) * N_DIRECTIONS + self.direction


def neighbours_of(arrays: SceneArrays) -> Neighbours:
    """Find the nearest neighbours of every object of a scene.

    Each object has `N_NEIGHBOURS` of them, or all others in a smaller scene.
    """
    first, second = _nearest(arrays.centre_enu_m)
    displacement_m = arrays.centre_enu_m[second] - arrays.centre_enu_m[first]
    east, north, up = displacement_m.T
    distance_m = np.hypot(east, north)
    is_on_top = distance_m < _ON_TOP_M
    direction = _sectors(np.arctan2(north, east) - arrays.yaw_rad[first])
    direction[is_on_top] = 0
    heading = _sectors(arrays.yaw_rad[second] - arrays.yaw_rad[first])
    # An object with two equal sides gives two views; the one with the neighbour ahead is taken.
    is_behind = _IS_TWO_SIDED[arrays.category[first]] & (direction >= _HALF)
    direction[is_behind] -= _HALF
    heading[is_behind] = (heading[is_behind] + _HALF) % N_DIRECTIONS
    is_either = _IS_TWO_SIDED[arrays.category]
    heading[is_either[second] | (is_either[first] & is_on_top)] %= _HALF
    return Neighbours(
        first=first,
        second=second,
        distance=np.searchsorted(DISTANCE_EDGES_M, distance_m),
        height=np.searchsorted(HEIGHT_EDGES_M, up),
        direction=direction,
        heading=heading,
    )


def _sectors(angle_rad: np.ndarray) -> np.ndarray:
    """Return the sectors of angles; the first sector lies around 0."""
    return np.floor(angle_rad / (2.0 * np.pi) * N_DIRECTIONS + 0.5).astype(int) % N_DIRECTIONS


def _nearest(centres: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    count = min(N_NEIGHBOURS, len(centres) - 1)
    if count < 1:
        return np.empty(0, dtype=int), np.empty(0, dtype=int)
    square = (centres**2).sum(axis=1)
    apart = square[:, None] + square - 2.0 * centres @ centres.T
    np.fill_diagonal(apart, np.inf)
    # Ties are broken by the place in the scene.
    second = np.argsort(apart, axis=1, kind="stable")[:, :count]
    return np.repeat(np.arange(len(centres)), count), second.ravel()
