"""Static geoms of the world body from a scene's primitives, at the least cost per step.

All solids are geoms of the world body itself and share meshes of equal shape: MuJoCo need not move
them, and never tests two of them for contact. `SurfaceProbe` asks the same geoms how high they are,
so a place found by it is exact.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import mujoco
import numpy as np
from jaxtyping import Float, Int

from aeroscene.scene import Relief
from aeroscene.solids.shapes import MATERIALS, Primitive
from flightsim.looks.geom_groups import GeomGroup
from flightsim.world.contact import STATIC_CONTACT, friction
from flightsim.world.ground import add_ground, add_ground_beyond

# Decoration is drawn, and neither touched nor measured.
_UNTOUCHABLE: dict[str, Any] = {"contype": 0, "conaffinity": 0, "group": int(GeomGroup.DECOR)}

_SIMPLE_TYPES = {
    "box": mujoco.mjtGeom.mjGEOM_BOX,
    "cylinder": mujoco.mjtGeom.mjGEOM_CYLINDER,
    "ellipsoid": mujoco.mjtGeom.mjGEOM_ELLIPSOID,
}


def add_solids(
    spec: mujoco.MjSpec, primitives: Iterable[Primitive], mesh_prefix: str = "mesh"
) -> None:
    """Add one geom per primitive, in order, in the plain colour of its material.

    Args:
        spec: Model to add to.
        primitives: The primitives.
        mesh_prefix: Beginning of the names of their meshes, another one for each call.
    """
    meshes: dict[tuple[tuple[float, ...], ...], str] = {}
    for primitive in primitives:
        spec.worldbody.add_geom(
            pos=primitive.position_enu_m,
            quat=primitive.quat_wxyz,
            rgba=MATERIALS[primitive.material].rgba,
            **_shape(spec, primitive, meshes, mesh_prefix),
            **(_contact(primitive) if primitive.collides else _UNTOUCHABLE),
        )


class SurfaceProbe:
    """Probe of the exact surface below points, in a model of ground and static solids alone."""

    def __init__(self, relief: Relief | None, solids: Sequence[Primitive]) -> None:
        spec, colliding = mujoco.MjSpec(), [solid for solid in solids if solid.collides]
        # The order gives the geoms their numbers: ground 0, the solids from 1 on, then the rest.
        add_ground(spec, relief)
        add_solids(spec, colliding)
        add_ground_beyond(spec, relief)
        self._n_known = 1 + len(colliding)
        self._model = spec.compile()
        self._data = mujoco.MjData(self._model)
        mujoco.mj_kinematics(self._model, self._data)
        self._geom = np.zeros(1, dtype=np.int32)

    def height_m(self, points_enu_m: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, " n"]:
        """Return the height of the first surface below each point; NaN where there is none."""
        return self.surfaces(points_enu_m)[0]

    def surfaces(
        self, points_enu_m: Float[np.ndarray, "n 3"]
    ) -> tuple[Float[np.ndarray, " n"], Int[np.ndarray, " n"]]:
        """Return the height of the first surface below each point, and the solid that has it.

        Args:
            points_enu_m: Points (n, 3), from which rays go down.

        Returns:
            Heights, NaN where there is none; and numbers, 0 for the ground, 1 + i for the i-th of
            the solids that collide, -1 for nothing.
        """
        heights, geoms = np.full(len(points_enu_m), np.nan), np.full(len(points_enu_m), -1)
        for i, point in enumerate(np.ascontiguousarray(points_enu_m, dtype=float)):
            depth_m = self.distance_m(point, np.array([0.0, 0.0, -1.0]))
            if depth_m < np.inf:
                geom = int(self._geom[0])
                # Geoms after the solids are the ground beyond a relief's grid.
                heights[i], geoms[i] = point[2] - depth_m, geom if geom < self._n_known else 0
        return heights, geoms

    def distance_m(
        self, point_enu_m: Float[np.ndarray, 3], direction_enu: Float[np.ndarray, 3]
    ) -> float:
        """Return the distance from a point to the first solid along a unit vector; else infinity.

        A point inside of a solid has the distance to the solid's surface.
        """
        # No geom groups, static geoms included, no body left out.
        hit_m = mujoco.mj_ray(
            self._model, self._data, point_enu_m, direction_enu, None, 1, -1, self._geom
        )
        return hit_m if hit_m >= 0.0 else np.inf


def _contact(primitive: Primitive) -> dict[str, Any]:
    return {**STATIC_CONTACT, "friction": friction(primitive.material)}


def _shape(
    spec: mujoco.MjSpec,
    primitive: Primitive,
    meshes: dict[tuple[tuple[float, ...], ...], str],
    mesh_prefix: str,
) -> dict[str, Any]:
    """Return the type and size of a geom; equal meshes are stored once."""
    if primitive.kind == "mesh":
        if primitive.vertices_m not in meshes:
            name = f"{mesh_prefix}{len(meshes)}"
            meshes[primitive.vertices_m] = name
            # The shell's inertia is defined for flat meshes too; static geoms need none.
            spec.add_mesh(
                name=name,
                uservert=np.array(primitive.vertices_m).ravel(),
                inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL,
            )
        return {"type": mujoco.mjtGeom.mjGEOM_MESH, "meshname": meshes[primitive.vertices_m]}
    x, y, z = primitive.size_m
    # MuJoCo expects half sizes, for a cylinder its radius and half length.
    size = (x / 2, z / 2, 0.0) if primitive.kind == "cylinder" else (x / 2, y / 2, z / 2)
    return {"type": _SIMPLE_TYPES[primitive.kind], "size": size}
