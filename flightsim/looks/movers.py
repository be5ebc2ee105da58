"""Triangles of movers: one mesh each for the physics, one per colour for pictures.

Both are the same surface, so that contacts, rangefinder, depth and colour agree.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import mujoco
import numpy as np
from jaxtyping import Float

from aeroscene.solids.shapes import MATERIALS, Primitive
from flightsim.environment.movers import MovingObstacle, mover_name, mover_primitives
from flightsim.looks.geom_groups import GeomGroup
from flightsim.looks.mesh import surface_enu
from flightsim.looks.surfaces import FAST

MOVER_CONTACT_BIT = 2
"""Contact bit of movers: they touch only the vehicle, which has this bit, not the static world."""
_FRICTION = (0.6, 0.005, 0.0001)


@dataclass(frozen=True, eq=False)
class MoverLooks:
    """Surface of one mover in its own frame."""

    corners_m: Float[np.ndarray, "t 3 3"]
    rgb: Float[np.ndarray, "t 3"]

    @classmethod
    def of(cls, primitives: Sequence[Primitive]) -> MoverLooks:
        """Return the surfaces of all solids, opaque."""
        parts = [surface_enu(primitive, FAST).corners_m() for primitive in primitives]
        colours = [MATERIALS[primitive.material].rgba[:3] for primitive in primitives]
        rgb = [np.tile(c, (len(part), 1)) for c, part in zip(colours, parts, strict=True)]
        return cls(np.concatenate(parts), np.concatenate(rgb))


class MoverSet:
    """Surfaces of several movers, and their poses in pictures."""

    def __init__(self, obstacles: Sequence[MovingObstacle]) -> None:
        self._obstacles = tuple(obstacles)

    def __len__(self) -> int:
        return len(self._obstacles)

    @cached_property
    def looks(self) -> tuple[MoverLooks, ...]:
        """Surface of each mover; made on first use."""
        return tuple(
            MoverLooks.of(mover_primitives(obstacle.kind, i))
            for i, obstacle in enumerate(self._obstacles)
        )

    def triangles_enu(self, data: mujoco.MjData) -> tuple[np.ndarray, np.ndarray]:
        """Return the triangles of all movers at the poses in `data`.

        Args:
            data: State of a model with the movers' bodies.

        Returns:
            Corners (t, 3, 3), ENU, and colours (t, 3), 0 to 1.
        """
        parts, colours = [np.zeros((0, 3, 3))], [np.zeros((0, 3))]
        rotation = np.empty(9)
        for looks, position, quat in zip(self.looks, data.mocap_pos, data.mocap_quat, strict=True):
            mujoco.mju_quat2Mat(rotation, quat)
            parts.append(looks.corners_m @ rotation.reshape(3, 3).T + position)
            colours.append(looks.rgb)
        return np.concatenate(parts), np.concatenate(colours)

    def triangle_counts(self) -> tuple[int, ...]:
        """Return the number of triangles of each mover, in the order of `triangles_enu`."""
        return tuple(len(looks.corners_m) for looks in self.looks)

    def add_solids(self, spec: mujoco.MjSpec) -> None:
        """Add a mocap body with one geom per mover, for the physics."""
        for name, body, looks in self._bodies(spec):
            _add_mesh(spec, name, looks.corners_m)
            body.add_geom(
                name=name,
                type=mujoco.mjtGeom.mjGEOM_MESH,
                meshname=name,
                rgba=(*looks.rgb.mean(axis=0), 1.0),
                friction=_FRICTION,
                contype=0,
                # Affinity alone: two movers never touch, and `let_touch` turns it on near a
                # vehicle.
                conaffinity=MOVER_CONTACT_BIT,
                condim=3,
                solmix=0.0,
                group=int(GeomGroup.MOVING),
            )

    def add_looks(self, spec: mujoco.MjSpec) -> None:
        """Add the same bodies with a geom per colour, without contacts."""
        for name, body, looks in self._bodies(spec):
            for k, rgb in enumerate(np.unique(looks.rgb, axis=0)):
                part = f"{name}_{k}"
                _add_mesh(spec, part, looks.corners_m[np.all(looks.rgb == rgb, axis=1)])
                body.add_geom(
                    type=mujoco.mjtGeom.mjGEOM_MESH,
                    meshname=part,
                    rgba=(*rgb, 1.0),
                    contype=0,
                    conaffinity=0,
                    group=int(GeomGroup.MOVING),
                )

    def _bodies(self, spec: mujoco.MjSpec) -> list[tuple[str, Any, MoverLooks]]:
        bodies = []
        for i, looks in enumerate(self.looks):
            name = mover_name(i, self._obstacles)
            start = self._obstacles[i].path_enu_m[0]
            bodies.append((name, spec.worldbody.add_body(name=name, mocap=True, pos=start), looks))
        return bodies


def _add_mesh(spec: mujoco.MjSpec, name: str, corners_m: np.ndarray) -> None:
    spec.add_mesh(
        name=name,
        uservert=corners_m.ravel(),
        userface=np.arange(3 * len(corners_m), dtype=np.int32),
        # A surface of many solids encloses no single volume.
        inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL,
    )
