"""Movers of a scene: people, cars and other drones, each on a path."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Literal

import numpy as np
from jaxtyping import Float

from aeroscene.scene import OrientedBox, SceneObject
from aeroscene.scene.catalogue import by_name
from aeroscene.solids.shapes import Part, Primitive, object_primitives
from aeroscene.solids.shapes.materials import FABRIC_COLOURS, PAINT_COLOURS
from aeroscene.solids.shapes.primitive import block, cylinder, ellipsoid
from autonomy.types import Vector3

MoverName = Literal["person", "car", "drone"]
MAX_MOVER_SPEED_MPS = 20.0
MAX_MOVERS = 64
_LEAST_PATH_M = 0.1
_UPRIGHT = (1.0, 0.0, 0.0, 0.0)


class MoverError(ValueError):
    """A moving obstacle is invalid."""


@dataclass(frozen=True, slots=True)
class MoverKind:
    """Properties common to all movers of a kind."""

    size_m: Vector3
    """Full extents; x is forward."""
    speed_mps: tuple[float, float]
    """Range of usual speeds."""
    acceleration_mps2: float
    """Acceleration at the ends of a to-and-fro path."""
    pause_s: float
    """Time of rest at each end of such a path."""
    turns_round: bool = False
    """True lets it turn round and return face first, instead of moving backwards."""

    @property
    def radius_m(self) -> float:
        """Radius of the sphere around its centre that contains it, m."""
        return math.hypot(*self.size_m) / 2


MOVER_KINDS: Mapping[MoverName, MoverKind] = MappingProxyType(
    {
        "person": MoverKind(
            (0.32, 0.62, 1.76), (0.8, 1.6), acceleration_mps2=1.0, pause_s=1.5, turns_round=True
        ),
        "car": MoverKind((4.3, 1.8, 1.5), (2.0, 5.0), acceleration_mps2=1.5, pause_s=1.0),
        "drone": MoverKind((0.6, 0.6, 0.2), (1.0, 3.0), acceleration_mps2=2.0, pause_s=0.5),
    }
)


@dataclass(frozen=True, kw_only=True, slots=True)
class MovingObstacle:
    """One mover on its path; its position depends on time alone."""

    kind: MoverName
    path_enu_m: tuple[Vector3, ...]
    """Corners of the path of the centre of its underside; they are rounded."""
    speed_mps: float
    is_loop: bool = False
    """True if the path is a loop; otherwise it is followed to and fro."""
    phase: float = 0.0
    """Share of a round, or of a return trip, completed at time zero, 0 to 1."""

    def __post_init__(self) -> None:
        """Refuse an invalid mover.

        Raises:
            MoverError: Naming the field, its value and the valid values.
        """
        if self.kind not in MOVER_KINDS:
            raise MoverError(f"kind {self.kind!r} is unknown; valid: {', '.join(MOVER_KINDS)}")
        path = np.array(self.path_enu_m, dtype=float)
        if path.ndim != 2 or path.shape[1] != 3 or not np.all(np.isfinite(path)):
            raise MoverError(f"path_enu_m = {self.path_enu_m}: finite points (x, y, z) are valid")
        length_m = float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())
        if length_m < _LEAST_PATH_M:
            raise MoverError(
                f"path_enu_m is {length_m:.2f} m long; valid: {_LEAST_PATH_M} m or more"
            )
        if not 0.0 < self.speed_mps <= MAX_MOVER_SPEED_MPS:
            raise MoverError(
                f"speed_mps = {self.speed_mps}: above 0 and up to {MAX_MOVER_SPEED_MPS:g} are valid"
            )
        if not 0.0 <= self.phase < 1.0:
            raise MoverError(f"phase = {self.phase}: 0 or more and below 1 is valid")


@dataclass(frozen=True, kw_only=True, eq=False)
class ObstacleStates:
    """True states of moving obstacles, one row each."""

    kinds: tuple[MoverName, ...]
    position_enu_m: Float[np.ndarray, "n 3"]
    """Centres of their boxes."""
    velocity_enu_mps: Float[np.ndarray, "n 3"]
    yaw_rad: Float[np.ndarray, " n"]
    """Directions of their boxes' x axes, counter-clockwise from east."""
    size_m: Float[np.ndarray, "n 3"]
    """Full extents of their boxes."""

    def __len__(self) -> int:
        return len(self.kinds)


def mover_name(index: int, obstacles: Sequence[MovingObstacle]) -> str:
    """Return the name of one of several movers, such as "person_0".

    Args:
        index: Index of the mover.
        obstacles: All movers; the name counts those of the same kind.
    """
    kind = obstacles[index].kind
    # Counted among its own kind, from 0.
    return f"{kind}_{sum(other.kind == kind for other in obstacles[:index])}"


def mover_primitives(kind: MoverName, number: int) -> tuple[Primitive, ...]:
    """Return the solids of a mover in its own frame: x forward, origin below its centre.

    Args:
        kind: Kind of the mover.
        number: Index among all movers, which determines its colours.
    """
    if kind == "car":
        # The catalogue's car, so that moving and parked cars look alike.
        size = MOVER_KINDS["car"].size_m
        car = SceneObject(
            id=number,
            scene_id="traffic",
            parent_id=None,
            category_id=by_name()["car"].id,
            bbox=OrientedBox((0.0, 0.0, size[2] / 2), _UPRIGHT, size),
            domain="outdoor",
            attributes={"colour": PAINT_COLOURS[number % len(PAINT_COLOURS)]},
        )
        return tuple(replace(part, object_id=number) for part in object_primitives(car))
    parts = _person(number) if kind == "person" else _drone(number)
    return tuple(
        Primitive(
            kind=part.kind,
            position_enu_m=part.position_m,
            quat_wxyz=part.quat_wxyz,
            size_m=part.size_m,
            material=part.material,
            object_id=number,
            collides=True,
        )
        for part in parts
    )


def _person(number: int) -> list[Part]:
    trousers = f"fabric_{FABRIC_COLOURS[(number + 2) % len(FABRIC_COLOURS)]}"
    shirt = f"fabric_{FABRIC_COLOURS[number % len(FABRIC_COLOURS)]}"
    legs = [cylinder((0.0, side * 0.1, 0.43), 0.18, 0.86, trousers) for side in (-1, 1)]
    arms = [cylinder((0.0, side * 0.26, 1.12), 0.1, 0.6, shirt) for side in (-1, 1)]
    chest = block((-0.13, 0.13), (-0.2, 0.2), (0.82, 1.45), shirt)
    head = ellipsoid((-0.11, 0.11), (-0.09, 0.09), (1.46, 1.76), "plaster_rose")
    return [*legs, *arms, chest, head]


def _drone(number: int) -> list[Part]:
    colour = f"paint_{PAINT_COLOURS[number % len(PAINT_COLOURS)]}"
    body = block((-0.12, 0.12), (-0.07, 0.07), (0.05, 0.16), colour)
    arms = [block((-0.2, 0.2), (y - 0.01, y + 0.01), (0.12, 0.14), "rubber") for y in (-0.17, 0.17)]
    beam = block((-0.01, 0.01), (-0.17, 0.17), (0.12, 0.14), "rubber")
    legs = [block((-0.1, 0.1), (y - 0.01, y + 0.01), (0.0, 0.06), "rubber") for y in (-0.06, 0.06)]
    rotors = [
        cylinder((x, y, 0.18), 0.25, 0.02, "rubber") for x in (-0.17, 0.17) for y in (-0.17, 0.17)
    ]
    return [body, *arms, beam, *legs, *rotors]
