"""MJCF: the world as MuJoCo's own XML, with solids, skins, vehicle and landing areas.

Solids collide and are in geom group 3, hidden by default; skins are visible and do not collide.
Names carry the semantics: `table_17_0` is the first solid of object 17, a table, and the sites
`landing_3_medium` are the areas. In the keyframe `start` the vehicle stands at the start.
"""

from __future__ import annotations

import itertools
import shutil
from collections import Counter
from pathlib import Path

import mujoco
import numpy as np

from aeroscene.files.names import file_name
from aeroscene.neighbourhood import neighbours_of
from aeroscene.scene import InteractionArea
from flightsim.export.files import staged, write_png
from flightsim.export.meshes import AREA_RGB, EXPORT_DETAIL, area_name, object_name
from flightsim.looks.drawing import add_looks
from flightsim.looks.geom_groups import GeomGroup
from flightsim.world import World, new_spec
from flightsim.world.geometry import add_solids
from flightsim.world.ground import add_ground, add_ground_beyond
from flightsim.world.starts import add_vehicles

_AREA_GROUP = 4  # hidden by default in MuJoCo's viewer too
_AREA_ALPHA = 0.5


def write_mjcf(world: World, folder: Path) -> Path:
    """Write `<scene>.xml`, its textures and meshes into a folder and return the XML's path.

    Args:
        world: World to write.
        folder: Destination, which is made if it is missing.

    Raises:
        ExportError: If the folder cannot be written.
    """
    name = f"{file_name(world.scene.scene_id)}.xml"
    with staged(folder) as stage:
        spec = _spec(world)
        # Compiling fills in the data of the textures, and checks the model.
        spec.compile()
        _put_textures_into_files(spec, stage)
        _put_meshes_into_files(spec, stage)
        (stage / name).write_text(spec.to_xml(), encoding="utf-8")
    return folder / name


def _spec(world: World) -> mujoco.MjSpec:
    spec = new_spec(world.scene, round(1.0 / world.model.opt.timestep))
    add_looks(spec, world.scene, world.solids, EXPORT_DETAIL)
    # These are skins: the solids that follow collide instead of them.
    for geom in spec.worldbody.geoms:
        geom.contype = geom.conaffinity = 0
    n_before = len(spec.worldbody.geoms)
    add_ground(spec, world.scene.relief)
    add_ground_beyond(spec, world.scene.relief)
    # The ground coincides with the skins that show it, and would flicker with them.
    for geom in itertools.islice(spec.worldbody.geoms, n_before, None):
        geom.group = int(GeomGroup.VEHICLE_SHAPE)
    solids = [solid for solid in world.solids if solid.collides]
    n_before = len(spec.worldbody.geoms)
    add_solids(spec, solids)
    count: Counter[str] = Counter()
    geoms = itertools.islice(spec.worldbody.geoms, n_before, None)
    for geom, solid in zip(geoms, solids, strict=True):
        label = object_name(world.scene.object_by_id[solid.object_id])
        geom.name = f"{label}_{count[label]}"
        geom.group = int(GeomGroup.VEHICLE_SHAPE)
        count[label] += 1
    _add_neighbours(spec, world)
    for area in world.scene.interaction_areas:
        _add_area(spec, area)
    if world.vehicle_body_id >= 0:
        add_vehicles(spec, world.vehicles)
        spec.add_key(name="start", qpos=world.rest_qpos)
    return spec


def _add_neighbours(spec: mujoco.MjSpec, world: World) -> None:
    """Add the solids around the site under the names `surroundings_0`, `surroundings_1`..."""
    n_before = len(spec.worldbody.geoms)
    solids = [part for part in neighbours_of(world.scene) if part.collides]
    add_solids(spec, solids, "neighbour")
    for number, geom in enumerate(itertools.islice(spec.worldbody.geoms, n_before, None)):
        geom.name = f"surroundings_{number}"
        geom.group = int(GeomGroup.VEHICLE_SHAPE)


def _add_area(spec: mujoco.MjSpec, area: InteractionArea) -> None:
    """Add a disc with the area's radius in the area's plane."""
    normal = plane_normal(area)
    quat = np.empty(4)
    mujoco.mju_quatZ2Vec(quat, normal)
    spec.worldbody.add_site(
        name=area_name(area),
        type=mujoco.mjtGeom.mjGEOM_CYLINDER,
        pos=area.centroid,
        quat=quat,
        size=(area.radius, 0.005, 0.0),
        rgba=(*AREA_RGB[area.drone_class], _AREA_ALPHA),
        group=_AREA_GROUP,
    )


def plane_normal(area: InteractionArea) -> np.ndarray:
    """Return the upward unit normal of an area's polygon, (3,), by Newell's sum over its edges.

    It needs no three corners that are not in a line, and evens out a polygon that is not quite
    flat.
    """
    vertices = np.array(area.polygon)
    following = np.roll(vertices, -1, axis=0)
    normal = np.cross(vertices, following).sum(axis=0)
    return normal / np.linalg.norm(normal)


def _put_meshes_into_files(spec: mujoco.MjSpec, folder: Path) -> None:
    """Copy the vehicle's mesh beside the XML, and refer to the copy."""
    for mesh in spec.meshes:
        if mesh.file:
            source = Path(mesh.file)
            (folder / "meshes").mkdir(exist_ok=True)
            shutil.copyfile(source, folder / "meshes" / source.name)
            mesh.file = source.name
            spec.meshdir = "meshes"


def _put_textures_into_files(spec: mujoco.MjSpec, folder: Path) -> None:
    """Move textures into files: MuJoCo's XML refers to pictures and cannot contain them."""
    spec.modelfiledir = str(folder)
    spec.texturedir = "textures"
    for texture in spec.textures:
        if texture.builtin == mujoco.mjtBuiltin.mjBUILTIN_NONE:
            shape = (texture.height, texture.width, texture.nchannel)
            picture = np.frombuffer(texture.data, np.uint8).reshape(shape)
            write_png(folder / "textures" / f"{texture.name}.png", picture)
            texture.file = f"{texture.name}.png"
            texture.data = b""
