"""One labelled frame: what a camera sees at a pose, and all that is known about it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float, Int, UInt8

from flightsim.cameras import CameraRenderer, RgbdFrame, Viewpoint
from flightsim.cameras.segmentation import Classes
from flightsim.world import World
from scenarios.images.labels.areas import area_labels, seen_areas
from scenarios.images.labels.flow import optical_flow
from scenarios.images.labels.objects import instances, movers_of, things_of
from scenarios.images.labels.projection import Pinhole
from scenarios.images.labels.surfaces import Surfaces
from scenarios.images.movers import Movers, motions
from scenarios.images.poses import CameraPose, PosePair

_VIEW = "images"
"""Name of the viewpoint; no camera of a vehicle has it."""


@dataclass(frozen=True, kw_only=True, eq=False)
class LabelledFrame:
    """Images of a frame, and its other labels as JSON knows them."""

    rgb: UInt8[np.ndarray, "h w 3"]
    next_rgb: UInt8[np.ndarray, "h w 3"]
    """The second image."""
    depth_m: Float[np.ndarray, "h w"]
    """Along the optical axis, inf in the sky."""
    normals: Float[np.ndarray, "h w 3"]
    """In the optical frame, 0 in the sky."""
    flow_px: Float[np.ndarray, "h w 2"]
    """To the second image: right, down."""
    flow_kind: UInt8[np.ndarray, "h w"]
    """See `scenarios.images.labels.flow`."""
    class_ids: UInt8[np.ndarray, "h w"]
    instance_ids: Int[np.ndarray, "h w"]
    facts: Mapping[str, Any]
    """Camera, poses, instances and landing areas."""


class Labeller:
    """Takes labelled frames of a world."""

    def __init__(self, world: World, renderer: CameraRenderer, width: int, height: int) -> None:
        """Prepare the labels of a world.

        Args:
            world: World, with movers or without.
            renderer: Renderer of it, which stays open.
            width: Width of the renderer's images.
            height: Height of the renderer's images.
        """
        self._world, self._renderer = world, renderer
        self._size = (width, height)
        self._data = world.new_data()
        self._surfaces = Surfaces(world)
        self._classes = Classes(world)
        self._things = things_of(world.scene)
        self._movers = Movers(world)

    def take(self, poses: PosePair, fov_rad: float, time_s: float, after_s: float) -> LabelledFrame:
        """Take one frame.

        Args:
            poses: Poses of the frame and of its second image.
            fov_rad: Field of view from left to right.
            time_s: Time of the frame, which places movers, rain and snow.
            after_s: Time from the frame to its second image.
        """
        width, height = self._size
        focal_px = width / 2 / math.tan(fov_rad / 2)
        first, second = (
            Pinhole(pose=pose, width=width, height=height, focal_px=focal_px)
            for pose in (poses.now, poses.next)
        )
        # The second image first, so that afterwards the movers are where the frame shows them.
        later = self._movers.place(self._data, time_s + after_s)
        next_frame = self._image(second, time_s + after_s)
        now = self._movers.place(self._data, time_s)
        frame = self._image(first, time_s)
        ids = self._renderer.render_ids_from(self._data, _viewpoint(first))
        normals, _ = self._surfaces.normals(first, self._data)
        normals[np.isinf(frame.depth_m)] = 0.0
        flow_px, flow_kind = optical_flow(
            first, second, frame.depth_m, next_frame.depth_m, ids, motions(now, later)
        )
        things = self._things | movers_of(self._world, self._classes, *now)
        areas = seen_areas(first, frame.depth_m, self._world.scene.interaction_areas)
        cx, cy = first.centre_px.tolist()
        return LabelledFrame(
            rgb=frame.rgb,
            next_rgb=next_frame.rgb,
            depth_m=frame.depth_m,
            normals=normals,
            flow_px=flow_px,
            flow_kind=flow_kind,
            class_ids=self._classes.of(ids),
            instance_ids=ids,
            facts={
                "camera": {
                    "width_px": width,
                    "height_px": height,
                    "focal_x_px": round(focal_px, 6),
                    "focal_y_px": round(focal_px, 6),
                    "centre_x_px": cx,
                    "centre_y_px": cy,
                    "fov_deg": round(math.degrees(fov_rad), 4),
                    "distortion": "none",
                },
                "pose": _pose(poses.now),
                "next": {"after_s": after_s, **_pose(poses.next)},
                "time_s": round(time_s, 3),
                "instances": instances(first, ids, things),
                "areas": area_labels(first, areas),
            },
        )

    def _image(self, camera: Pinhole, time_s: float) -> RgbdFrame:
        return self._renderer.render_from(self._data, _viewpoint(camera), round(1e6 * time_s))


def _viewpoint(camera: Pinhole) -> Viewpoint:
    return Viewpoint(
        name=_VIEW,
        position_enu_m=camera.pose.position_enu_m,
        rotation_enu_from_optical=camera.pose.rotation_enu_from_optical,
        vertical_fov_rad=2 * math.atan(camera.height / 2 / camera.focal_px),
    )


def _pose(pose: CameraPose) -> dict[str, Any]:
    return {
        "position_enu_m": pose.position_enu_m.tolist(),
        "quat_wxyz": pose.quat_wxyz,
    }
