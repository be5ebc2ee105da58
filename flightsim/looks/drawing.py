"""How a world looks: a second MuJoCo model, made for drawing, beside the one that is stepped.

Physics wants few plain solids; a picture wants textures in their true size on every face, which
MuJoCo's own boxes do not give. Here the static solids are merged into one skin for each material
and tile of ground: some 200 meshes that draw faster than 900 geoms and are culled well. The vehicle
is the same in both models, so that one's `qpos` poses the other.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from aeroscene.scene import Scene
from aeroscene.shapes import MATERIALS, Material, Primitive
from flightsim.geom_groups import GeomGroup
from flightsim.looks.tessellation import Surface, box, cylinder, ellipsoid, hull
from flightsim.looks.textures import TILE_PIXELS, tile
from flightsim.sensors.sky import HORIZON_RGB, ZENITH_RGB

GROUND_MATERIAL = "grass"

_SKIN_TILE_M = 16.0


@dataclass(frozen=True, kw_only=True, slots=True)
class Detail:
    """Sides of round things."""

    slices: int
    stacks: int


FAST = Detail(slices=14, stacks=8)
"""What software rendering at camera rate affords."""
FINE = Detail(slices=40, stacks=24)


def set_view(spec: mujoco.MjSpec, scene: Scene) -> None:
    """Clip planes, light and sky, the same in both models."""
    low, high = np.array(scene.extent_min_enu_m), np.array(scene.extent_max_enu_m)
    spec.stat.center = (low + high) / 2
    spec.stat.extent = float(np.linalg.norm(high - low)) / 2
    visual: Any = spec.visual
    visual.map.znear = 0.03 / spec.stat.extent
    visual.map.zfar = 12.0
    visual.quality.offsamples = 0
    visual.quality.numslices = FAST.slices
    visual.quality.numstacks = FAST.stacks
    visual.quality.numquads = 1
    # No shadows but in fine pictures, whose renderer sets its own; a map costs start-up time.
    visual.quality.shadowsize = 0
    visual.headlight.ambient = (0.42, 0.43, 0.46)
    visual.headlight.diffuse = (0.10, 0.10, 0.10)
    visual.headlight.specular = (0.0, 0.0, 0.0)
    spec.worldbody.add_light(
        name="sun",
        type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
        pos=(0.0, 0.0, 100.0),
        dir=(0.45, 0.30, -0.84),
        diffuse=(0.58, 0.56, 0.50),
        specular=(0.15, 0.15, 0.15),
        ambient=(0.0, 0.0, 0.0),
        castshadow=True,
    )
    spec.add_texture(
        name="sky",
        type=mujoco.mjtTexture.mjTEXTURE_SKYBOX,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT,
        rgb1=ZENITH_RGB,
        rgb2=HORIZON_RGB,
        width=128,
        height=768,
    )


def add_looks(spec: mujoco.MjSpec, primitives: Iterable[Primitive], detail: Detail) -> None:
    """Add the ground and the skins of static solids to the world body."""
    ground = MATERIALS[GROUND_MATERIAL]
    _add_material(spec, "ground", ground, ground.texture_size_m)
    spec.worldbody.add_geom(
        name="ground",
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        size=(0.0, 0.0, 1.0),
        material="ground",
        group=int(GeomGroup.SCENE),
    )
    skins: dict[tuple[str, int, int], list[Surface]] = defaultdict(list)
    for primitive in primitives:
        x, y, _ = primitive.position_enu_m
        key = (primitive.material, int(x // _SKIN_TILE_M), int(y // _SKIN_TILE_M))
        skins[key].append(surface_enu(primitive, detail))
    for name in dict.fromkeys(material for material, _, _ in skins):
        _add_material(spec, name, MATERIALS[name], None)
    for index, ((material, _, _), surfaces) in enumerate(skins.items()):
        _add_skin(spec, f"skin{index}", MATERIALS[material], surfaces)


def surface_enu(primitive: Primitive, detail: Detail) -> Surface:
    """The surface of a primitive in the world."""
    local = _local_surface(primitive, detail)
    rotation = np.empty(9)
    mujoco.mju_quat2Mat(rotation, np.array(primitive.quat_wxyz))
    turn = rotation.reshape(3, 3).T
    return Surface(
        local.vertices_m @ turn + primitive.position_enu_m,
        local.normals @ turn,
        local.texture_m,
        local.triangles,
    )


def _local_surface(primitive: Primitive, detail: Detail) -> Surface:
    size_m = np.array(primitive.size_m)
    if primitive.kind == "box":
        return box(size_m)
    if primitive.kind == "ellipsoid":
        return ellipsoid(size_m, detail.slices, detail.stacks)
    if primitive.kind == "cylinder":
        return cylinder(float(size_m[0]) / 2, float(size_m[2]), detail.slices)
    return hull(np.array(primitive.vertices_m))


def _add_material(
    spec: mujoco.MjSpec, name: str, material: Material, repeat_m: tuple[float, float] | None
) -> None:
    """A MuJoCo material; `repeat_m` is for geoms without texture coordinates of their own."""
    surface = spec.add_material(
        name=name,
        rgba=material.rgba,
        specular=material.specular,
        shininess=material.shininess,
        reflectance=0.0,
    )
    if material.texture is None:
        return
    red, green, blue, alpha = material.rgba
    texture = spec.add_texture(
        name=name,
        type=mujoco.mjtTexture.mjTEXTURE_2D,
        width=TILE_PIXELS,
        height=TILE_PIXELS,
        nchannel=3,
    )
    texture.data = tile(material.texture, (red, green, blue)).tobytes()
    surface.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = name
    # The texture carries the colour.
    surface.rgba = (1.0, 1.0, 1.0, alpha)
    if repeat_m is not None:
        surface.texuniform = True
        surface.texrepeat = (1.0 / repeat_m[0], 1.0 / repeat_m[1])


def _add_skin(spec: mujoco.MjSpec, name: str, material: Material, surfaces: list[Surface]) -> None:
    """One mesh from many surfaces; texture coordinates count tiles, v down as in MuJoCo."""
    first = np.cumsum([0] + [len(s.vertices_m) for s in surfaces[:-1]])
    triangles = np.concatenate([s.triangles + f for s, f in zip(surfaces, first, strict=True)])
    faces = triangles.astype(np.int32).ravel()
    per_metre = np.array([1.0, -1.0]) / material.texture_size_m
    texture = np.concatenate([s.texture_m for s in surfaces]) * per_metre
    spec.add_mesh(
        name=name,
        uservert=np.concatenate([s.vertices_m for s in surfaces]).ravel(),
        usernormal=np.concatenate([s.normals for s in surfaces]).ravel(),
        usertexcoord=texture.ravel(),
        userface=faces,
        userfacenormal=faces,
        userfacetexcoord=faces,
        # A skin need not enclose a volume.
        inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL,
    )
    spec.worldbody.add_geom(
        type=mujoco.mjtGeom.mjGEOM_MESH,
        meshname=name,
        material=material.name,
        contype=0,
        conaffinity=0,
        group=int(GeomGroup.SCENE),
    )
