import json
import struct

import numpy as np
import pytest
import trimesh

from aeroscene.scene.box import box_corners


@pytest.fixture(scope="module")
def reopened(glb_path):
    return trimesh.load_scene(glb_path, process=False)


@pytest.fixture(scope="module")
def document(glb_path):
    """The JSON chunk of the file."""
    content = glb_path.read_bytes()
    magic, version, total, length = struct.unpack("<4I", content[:16])
    assert (magic, version, total) == (0x46546C67, 2, len(content))
    return json.loads(content[20 : 20 + length])


def to_enu(points):
    """glTF is y-up: x east, y up, z south."""
    return np.stack([points[:, 0], -points[:, 2], points[:, 1]], axis=1)


def test_every_object_fills_its_box(world, reopened):
    for obj in world.scene.objects:
        prefix = f"{obj.category}_{obj.id}_"
        corners = [
            trimesh.transform_points(reopened.geometry[name].vertices, reopened.graph.get(node)[0])
            for node in reopened.graph.nodes_geometry
            for name in [reopened.graph.get(node)[1]]
            if node.startswith(prefix)
        ]
        points = to_enu(np.concatenate(corners))
        box = box_corners(obj.bbox.p, obj.bbox.q, obj.bbox.s)
        assert np.all(points.min(axis=0) >= box.min(axis=0) - 0.05), obj
        assert np.all(points.max(axis=0) <= box.max(axis=0) + 0.05), obj


def test_nodes_follow_the_hierarchy_and_carry_the_semantics(world, document):
    nodes = document["nodes"]
    index = {node["name"]: number for number, node in enumerate(nodes)}
    for obj in world.scene.objects:
        node = nodes[index[f"{obj.category}_{obj.id}"]]
        assert node["extras"]["id"] == obj.id
        assert node["extras"]["category"] == obj.category
        parent = "scene_enu"
        if obj.parent_id is not None:
            parent = f"{world.scene.object_by_id[obj.parent_id].category}_{obj.parent_id}"
        assert index[node["name"]] in nodes[index[parent]]["children"]
    assert nodes[index["scene_enu"]]["extras"]["scene_id"] == world.scene.scene_id


def test_textures_are_inside_the_file_once_each(world, document):
    textured = {m["name"] for m in document["materials"] if "baseColorTexture" in _pbr(m)}
    assert len(textured) > 10
    assert len(document["images"]) <= len(textured)
    assert all("bufferView" in image for image in document["images"])


def _pbr(material):
    return material["pbrMetallicRoughness"]


def test_areas_lie_on_what_bears_them(world, reopened, document):
    extras = {node["name"]: node.get("extras") for node in document["nodes"]}
    for area in world.scene.interaction_areas:
        name = f"{area.kind}_{area.id}_{area.drone_class}"
        assert extras[name]["surface"] == area.surface
        transform, geometry = reopened.graph.get(f"{name}_polygon")
        points = to_enu(trimesh.transform_points(reopened.geometry[geometry].vertices, transform))
        middle = points.mean(axis=0)
        assert middle[2] == pytest.approx(area.centroid[2] + 0.02, abs=0.3)
        reach = np.linalg.norm(points[:, :2] - area.centroid[:2], axis=1).max()
        assert reach >= area.radius * 0.99
