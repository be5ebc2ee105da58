"""GLB: the scene as one glTF 2.0 file with its textures inside, for viewers and game engines.

Nodes follow the hierarchy, `building_3` holds `room_7` holds `table_12`, and carry `id`,
`category`, `domain` and the attributes as glTF extras. glTF is y-up: the root node rotates ours.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from aeroscene.scene import InteractionArea, Scene, SceneObject
from aeroscene.solids.shapes import MATERIALS, Material
from flightsim.export.files import staged
from flightsim.export.meshes import ObjectMesh, object_meshes
from flightsim.looks.tessellation import Surface
from flightsim.looks.textures import tile
from flightsim.world import World

if TYPE_CHECKING:
    import trimesh

ROOT = "scene_enu"
"""Node whose axes are east, north and up."""

_GLTF_FROM_ENU = np.array(
    [[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, -1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]]
)
_AREA_RGBA = {
    "small": (51, 166, 242, 160),
    "medium": (51, 204, 102, 160),
    "large": (250, 166, 38, 160),
}
_AREA_LIFT_M = 0.02
"""Height at which areas are drawn above their supporting surface."""


def write_glb(world: World, folder: Path) -> Path:
    """Write `<scene>.glb` into a folder and return its path.

    Raises:
        ExportError: If the folder cannot be written.
    """
    name = f"{world.scene.scene_id}.glb"
    with staged(folder) as stage:
        _graph(world).export(stage / name, file_type="glb")
    return folder / name


def _graph(world: World) -> trimesh.Scene:
    import trimesh  # noqa: PLC0415 - heavy, and only this export needs it

    graph = trimesh.Scene(base_frame="world")
    graph.graph.update(ROOT, "world", matrix=_GLTF_FROM_ENU, metadata=_scene_extras(world.scene))
    materials = {
        name: _material(MATERIALS[name])
        for name in dict.fromkeys(solid.material for solid in world.solids)
    }
    for mesh in object_meshes(world.scene, world.solids):
        _add_object(graph, mesh, world.scene, materials)
    for area in world.scene.interaction_areas:
        _add_area(graph, area)
    return graph


def object_name(obj: SceneObject) -> str:
    """Name of an object's node."""
    return f"{obj.category}_{obj.id}"


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
    import trimesh  # noqa: PLC0415 - as above
    from trimesh.visual import TextureVisuals  # noqa: PLC0415 - as above

    return trimesh.Trimesh(
        vertices=skin.vertices_m,
        faces=skin.triangles,
        vertex_normals=skin.normals,
        visual=TextureVisuals(uv=skin.texture_m / look.texture_size_m, material=material),
        process=False,
    )


def _material(look: Material) -> Any:
    from PIL import Image  # noqa: PLC0415 - only this export needs it
    from trimesh.visual.material import PBRMaterial  # noqa: PLC0415 - as above

    return PBRMaterial(
        name=look.name,
        # The texture carries the colour.
        baseColorFactor=(1.0, 1.0, 1.0, 1.0) if look.texture else look.rgba,
        baseColorTexture=(
            Image.fromarray(tile(look.texture, look.rgba[:3])) if look.texture else None
        ),
        metallicFactor=0.0,
        roughnessFactor=1.0 - 0.7 * look.specular,
    )


def _add_area(graph: trimesh.Scene, area: InteractionArea) -> None:
    """Add the area's polygon as a fan around its centroid."""
    import trimesh  # noqa: PLC0415 - as above

    ring = np.array([area.centroid, *area.polygon])
    ring[:, 2] += _AREA_LIFT_M
    n = len(area.polygon)
    fan = [(0, 1 + i, 1 + (i + 1) % n) for i in range(n)]
    name = f"{area.kind}_{area.id}_{area.drone_class}"
    extras = {
        "kind": area.kind,
        "drone_class": area.drone_class,
        "radius_m": area.radius,
        "slope_rad": area.slope_rad,
        "clearance_m": area.clearance_m,
        "surface": area.surface,
        "object_id": -1 if area.object_id is None else area.object_id,
    }
    mesh = trimesh.Trimesh(ring, fan, face_colors=_AREA_RGBA[area.drone_class], process=False)
    graph.graph.update(name, ROOT, matrix=np.eye(4), metadata=extras)
    graph.add_geometry(
        mesh, node_name=f"{name}_polygon", geom_name=f"{name}_polygon", parent_node_name=name
    )


def _scene_extras(scene: Scene) -> dict[str, Any]:
    return {
        "scene_id": scene.scene_id,
        "domain": scene.domain,
        "start_position_enu_m": list(scene.start_position_enu_m),
        "latitude_deg": scene.latitude_deg,
        "longitude_deg": scene.longitude_deg,
        "altitude_m": scene.altitude_m,
    }
