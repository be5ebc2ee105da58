"""Primitives of a scene as static geoms: shapes, surfaces, textures.

A static geom belongs to the world body (a body of its own would cost four times as much a step).
Boxes, cylinders and ellipsoids stay what they are; any other convex solid becomes a mesh.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import mujoco
import numpy as np

from aeroscene.shapes import Material, Primitive
from flightsim.geom_groups import GeomGroup
from flightsim.hull import flat_shaded_hull
from flightsim.textures import TILE_PIXELS, tile

_SIMPLE_TYPES = {
    "box": mujoco.mjtGeom.mjGEOM_BOX,
    "cylinder": mujoco.mjtGeom.mjGEOM_CYLINDER,
    "ellipsoid": mujoco.mjtGeom.mjGEOM_ELLIPSOID,
}


class StaticGeometry:
    """Adds primitives to a spec, each surface and each mesh once."""

    def __init__(self, spec: mujoco.MjSpec, materials: Mapping[str, Material]) -> None:
        self._spec = spec
        self._materials = materials
        self._surfaces: set[str] = set()
        self._meshes: dict[bytes, str] = {}

    def add(self, primitives: Iterable[Primitive]) -> list[int]:
        """Add geoms to the world body, in order; returns the object id of each."""
        object_ids = []
        for primitive in primitives:
            self._spec.worldbody.add_geom(
                pos=primitive.position_enu_m,
                quat=primitive.quat_wxyz,
                material=self.surface(primitive.material),
                **self._shape(primitive),
                **self._contact(primitive),
            )
            object_ids.append(primitive.object_id)
        return object_ids

    def surface(self, name: str) -> str:
        """Name of the MuJoCo material for one of the scene's materials, made on first use."""
        if name not in self._surfaces:
            self._surfaces.add(name)
            self._add_surface(self._materials[name])
        return name

    def _add_surface(self, material: Material) -> None:
        surface = self._spec.add_material(
            name=material.name,
            rgba=material.rgba,
            specular=material.specular,
            shininess=material.shininess,
            reflectance=0.0,
        )
        if material.texture is None:
            return
        red, green, blue, alpha = material.rgba
        texture = self._spec.add_texture(
            name=material.name,
            type=mujoco.mjtTexture.mjTEXTURE_2D,
            width=TILE_PIXELS,
            height=TILE_PIXELS,
            nchannel=3,
        )
        texture.data = tile(material.texture, (red, green, blue)).tobytes()
        surface.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = material.name
        length_m, height_m = material.texture_size_m
        # MuJoCo scales texture coordinates by half sizes: one repeat is 2 m long.
        surface.texrepeat = (2.0 / length_m, 2.0 / height_m)
        surface.texuniform = True
        # The texture carries the colour.
        surface.rgba = (1.0, 1.0, 1.0, alpha)

    def _shape(self, primitive: Primitive) -> dict[str, Any]:
        x, y, z = primitive.size_m
        if primitive.kind == "mesh":
            return self._mesh(np.asarray(primitive.vertices_m, dtype=float))
        # MuJoCo wants half sizes, of a cylinder radius and half length.
        size = (x / 2, z / 2, 0.0) if primitive.kind == "cylinder" else (x / 2, y / 2, z / 2)
        return {"type": _SIMPLE_TYPES[primitive.kind], "size": size}

    def _mesh(self, vertices_m: np.ndarray) -> dict[str, Any]:
        key = vertices_m.tobytes()
        if key not in self._meshes:
            name = f"mesh{len(self._meshes)}"
            self._meshes[key] = name
            vertices, uv, faces = flat_shaded_hull(vertices_m)
            # The shell's inertia is defined for flat meshes too; static geoms need none.
            self._spec.add_mesh(
                name=name,
                uservert=vertices.ravel(),
                usertexcoord=uv.ravel(),
                userface=faces.ravel(),
                inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL,
            )
        return {"type": mujoco.mjtGeom.mjGEOM_MESH, "meshname": self._meshes[key]}

    def _contact(self, primitive: Primitive) -> dict[str, Any]:
        if not primitive.collides:
            return {"contype": 0, "conaffinity": 0, "group": int(GeomGroup.DECOR)}
        return {
            **STATIC_CONTACT,
            "friction": (self._materials[primitive.material].friction, 0.005, 0.0001),
        }


# The vehicle's softness decides (solmix 0); the larger friction of the two does.
STATIC_CONTACT: dict[str, Any] = {
    "contype": 1,
    "conaffinity": 1,
    "condim": 3,
    "solmix": 0.0,
    "group": int(GeomGroup.SCENE),
}
