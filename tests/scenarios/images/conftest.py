"""A small set of labelled images, made once by the command."""

import json
from typing import Any, NamedTuple

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from scenarios.cli.main import main
from scenarios.images.encoding import depth_of, flow_of, ids_of, normals_of
from scenarios.images.labels.projection import Pinhole
from scenarios.images.poses import CameraPose
from scenarios.images.reading import FrameReader

N_FRAMES = 8
MADE = (
    *("images", "--scenes", "42", "--count", N_FRAMES, "--size", "160x120", "--seed", 5),
    *("--light", "16:00, clear", "--season", "summer", "--traffic", "people=3,cars=1"),
    *("--next-after", 0.3, "--jobs", 1),
)


class Frame(NamedTuple):
    """A frame as it was read from its shard."""

    facts: dict[str, Any]
    depth_m: np.ndarray
    normals: np.ndarray
    flow_px: np.ndarray
    flow_kind: np.ndarray
    ids: np.ndarray

    @property
    def camera(self):
        return _camera(self.facts, self.facts["pose"])

    @property
    def next_camera(self):
        return _camera(self.facts, self.facts["next"])

    @property
    def points_enu_m(self):
        """Point in the world of each pixel (h, w, 3); not finite in the sky."""
        camera = self.camera
        depth_m = self.depth_m[..., None]
        local = np.where(np.isinf(depth_m), np.nan, camera.rays() * depth_m)
        return local @ camera.pose.rotation_enu_from_optical.T + camera.pose.position_enu_m


def _camera(facts, pose):
    lens = facts["camera"]
    turn = Rotation.from_quat(pose["quat_wxyz"], scalar_first=True).as_matrix()
    return Pinhole(
        pose=CameraPose(
            position_enu_m=np.array(pose["position_enu_m"]), rotation_enu_from_optical=turn
        ),
        width=lens["width_px"],
        height=lens["height_px"],
        focal_px=lens["focal_x_px"],
    )


@pytest.fixture(scope="session")
def folder(tmp_path_factory):
    out = tmp_path_factory.mktemp("images") / "set"
    sheet = out.parent / "sheet.png"
    assert main([str(word) for word in (*MADE, "--out", out, "--sheet", sheet)]) == 0
    return out


@pytest.fixture(scope="session")
def frames(folder):
    reader = FrameReader(folder)
    assert reader.n_frames == N_FRAMES
    return [_frame(reader, index) for index in range(N_FRAMES)]


def _frame(reader, index):
    flow_px, kind = flow_of(reader.image(index, "flow.png"))
    return Frame(
        facts=json.loads(reader.read(index, "json")),
        depth_m=depth_of(reader.image(index, "depth.png")),
        normals=normals_of(reader.image(index, "normals.png")),
        flow_px=flow_px,
        flow_kind=kind,
        ids=ids_of(reader.image(index, "instances.png")),
    )
