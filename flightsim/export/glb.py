"""GLB: the scene as one glTF 2.0 file with its textures inside, for viewers and game engines.

Nodes follow the hierarchy: `building_3` holds `room_7`, which holds `table_12`. They carry `id`,
`category`, `domain` and the attributes as glTF extras. glTF is y-up, so the root node rotates our
axes, and all nodes below it are in ours. There are no colliders and no vehicle, since glTF knows
neither.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from PIL import Image
from trimesh.visual import TextureVisuals
from trimesh.visual.material import PBRMaterial

from aeroscene.files.names import file_name
from aeroscene.neighbourhood import neighbours_of
from aeroscene.scene import InteractionArea, Relief, Scene
from aeroscene.solids.shapes import MATERIALS, Material
from flightsim.export.files import staged
from flightsim.export.meshes import (
    AREA_RGB,
    ObjectMesh,
    area_facts,
    area_name,
    neighbour_skins,
    object_meshes,
    object_name,
    scene_facts,
)
from flightsim.looks.relief_ground import relief_surface
from flightsim.looks.surroundings import GROUND_MATERIAL
from flightsim.looks.tessellation import Surface
from flightsim.looks.textures import tile
from flightsim.world import World

ROOT = "scene_enu"
"""Node whose axes are east, north and up."""
GROUND = "ground"
"""Node of the ground of a relief; without a relief the ground is no part of the file."""

SURROUNDINGS = "surroundings"
"""Beginning of the names of the nodes of the land around the site, one for each material."""

# Up becomes y, and north becomes -z.
_GLTF_FROM_ENU = np.array(
    [[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, -1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]]
)
_AREA_ALPHA = 160  # of 255
_AREA_LIFT_M = 0.02
"""Height at which areas are drawn above their supporting surface, so that both do not flicker."""


def write_glb(world: World, folder: Path) -> Path:
    """Write `<scene>.glb` into a folder and return its path.

    Args:
        world: World to write.
        folder: Destination, which is made if it is missing.

    Raises:
        ExportError: If the folder cannot be written.
    """
    name = f"{file_name(world.scene.scene_id)}.glb"
    with staged(folder) as stage:
        _graph(world).export(stage / name, file_type="glb")
    return folder / name


def _graph(world: World) -> trimesh.Scene:
    graph = trimesh.Scene(base_frame="world")
    start = {"start_position_enu_m": list(world.scene.start_position_enu_m)}
    extras = scene_facts(world.scene) | start
    graph.graph.update(ROOT, "world", matrix=_GLTF_FROM_ENU, metadata=extras)
    around = neighbours_of(world.scene)
    # One material for all of its meshes, so each texture is stored once.
    materials = {
        name: _material(MATERIALS[name])
        for name in dict.fromkeys(solid.material for solid in (*world.solids, *around))
    }
    for material, skin in neighbour_skins(world.scene).items():
        name = f"{SURROUNDINGS}_{material}"
        mesh = _trimesh(skin, materials[material], MATERIALS[material])
        graph.add_geometry(mesh, node_name=name, geom_name=name, parent_node_name=ROOT)
    if world.scene.relief is not None:
        _add_relief(graph, world.scene.relief)
    # Parents come before their children, so each node finds its parent.
    for mesh in object_meshes(world.scene, world.solids):
        _add_object(graph, mesh, world.scene, materials)
    for area in world.scene.interaction_areas:
        _add_area(graph, area)
    return graph


def _add_relief(graph: trimesh.Scene, relief: Relief) -> None:
    """Add the grid of the relief as the node `ground`."""
    look = MATERIALS[GROUND_MATERIAL]
    mesh = _trimesh(relief_surface(relief, 0.0), _material(look), look)
    graph.add_geometry(mesh, node_name=GROUND, geom_name=GROUND, parent_node_name=ROOT)


def _add_object(
    graph: trimesh.Scene, mesh: ObjectMesh, scene: Scene, materials: dict[str, Any]
) -> None:
    obj = mesh.obj
    parent = ROOT if obj.parent_id is None else object_name(scene.object_by_id[obj.parent_id])
    extras = {"id": obj.id, "category": obj.category, "domain": obj.domain, **obj.attributes}
    graph.graph.update(object_name(obj), parent, matrix=mesh.pose_parent, metadata=extras)
    for material, skin in mesh.skins.items():
        name = f"{object_name(obj)}_{material}"
        graph.add_geometry(
            _trimesh(skin, materials[material], MATERIALS[material]),
            node_name=name,
            geom_name=name,
            parent_node_name=object_name(obj),
        )


def _trimesh(skin: Surface, material: Any, look: Material) -> trimesh.Trimesh:
    return trimesh.Trimesh(
        vertices=skin.vertices_m,
        faces=skin.triangles,
        vertex_normals=skin.normals,
        visual=TextureVisuals(uv=skin.texture_m / look.texture_size_m, material=material),
        process=False,  # as it is: trimesh would merge equal vertices
    )


def _material(look: Material) -> Any:
    return PBRMaterial(
        name=look.name,
        # The texture carries the colour.
        baseColorFactor=(1.0, 1.0, 1.0, 1.0) if look.texture else look.rgba,
        baseColorTexture=(
            Image.fromarray(tile(look.texture, look.rgba[:3])) if look.texture else None
        ),
        metallicFactor=0.0,
        # Shiny materials get less rough; 0.3 is the least.
        roughnessFactor=1.0 - 0.7 * look.specular,
    )


def _add_area(graph: trimesh.Scene, area: InteractionArea) -> None:
    """Add the area's polygon as a fan around its centroid."""
    ring = np.array([area.centroid, *area.polygon])
    ring[:, 2] += _AREA_LIFT_M
    n = len(area.polygon)
    fan = [(0, 1 + i, 1 + (i + 1) % n) for i in range(n)]
    name = area_name(area)
    extras = {"kind": area.kind, **area_facts(area)}
    rgba = (*(round(255 * c) for c in AREA_RGB[area.drone_class]), _AREA_ALPHA)
    mesh = trimesh.Trimesh(ring, fan, face_colors=rgba, process=False)
    graph.graph.update(name, ROOT, matrix=np.eye(4), metadata=extras)
    graph.add_geometry(
        mesh, node_name=f"{name}_polygon", geom_name=f"{name}_polygon", parent_node_name=name
    )
