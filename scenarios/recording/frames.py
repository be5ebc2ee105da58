"""Camera frames in a recording: JPEG colour, 16-bit PNG depth and segments under a pinhole."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import rerun as rr
from jaxtyping import Float, Integer

from aeroscene.scene import Scene
from flightsim.stored_depth import DEPTH_UNITS_PER_M, MOST_DEPTH_M, depth_to_uint16
from scenarios.recording import layout
from scenarios.recording.entity_stream import EntityStream

if TYPE_CHECKING:
    from flightsim.cameras import RgbdFrame

JPEG_QUALITY = 85
_SHOWN_DEPTHS_M = (2.0, 5.0, 10.0, 20.0, 40.0, MOST_DEPTH_M)
"""Depths that the last colour may stand for. They are few, so that colours rarely change."""
_NEARLY_ALL = 0.95
_FRUSTUM_M = 0.6  # distance from the camera at which viewers draw its image in the scene


class FrameLog:
    """Writes camera frames, and each camera's pinhole before its first frame."""

    def __init__(self, stream: EntityStream, scene: Scene) -> None:
        self._stream, self._scene = stream, scene
        self._intrinsics: dict[str, tuple[float, ...]] = {}
        self._segmented: set[str] = set()

    def log(self, frame: RgbdFrame, *, has_colour: bool) -> None:
        """Write a frame at the stream's present time.

        Args:
            frame: Frame of a camera.
            has_colour: False writes the depth alone, without colours, classes and objects.
        """
        self._log_pinhole(frame)
        if has_colour:
            colour = rr.Image(frame.rgb).compress(jpeg_quality=JPEG_QUALITY)
            self._stream.log(layout.camera_rgb(frame.camera), colour)
        self._stream.log(
            layout.camera_depth(frame.camera),
            rr.EncodedDepthImage(
                encode_png(depth_to_uint16(frame.depth_m)),
                media_type="image/png",
                meter=DEPTH_UNITS_PER_M,
                colormap=rr.components.Colormap.Turbo,
                depth_range=(0.0, DEPTH_UNITS_PER_M * shown_depth_m(frame.depth_m)),
            ),
        )

        if has_colour and frame.instance_ids is not None and frame.class_ids is not None:
            self._log_segments(frame.camera, frame.instance_ids, frame.class_ids)

    def _log_segments(self, camera: str, instances: np.ndarray, classes: np.ndarray) -> None:
        """Write images of classes and objects; the names of their numbers come before the first."""
        if camera not in self._segmented:
            self._segmented.add(camera)
            for entity, names in (
                (layout.camera_classes(camera), _class_names()),
                (layout.camera_instances(camera), _instance_names(self._scene)),
            ):
                self._stream.log(entity, rr.AnnotationContext(sorted(names.items())), static=True)
        self._stream.log(layout.camera_classes(camera), rr.SegmentationImage(classes))
        # rerun takes unsigned numbers: ids below zero wrap around, -1 becomes 65535.
        self._stream.log(
            layout.camera_instances(camera), rr.SegmentationImage(instances.astype(np.uint16))
        )

    def _log_pinhole(self, frame: RgbdFrame) -> None:
        height, width = frame.depth_m.shape
        intrinsics = (frame.fx, frame.fy, frame.cx, frame.cy, width, height)
        if self._intrinsics.get(frame.camera) == intrinsics:
            return
        self._intrinsics[frame.camera] = intrinsics
        self._stream.log(
            layout.camera(frame.camera),
            rr.Pinhole(
                focal_length=[float(frame.fx), float(frame.fy)],
                principal_point=[float(frame.cx), float(frame.cy)],
                width=width,
                height=height,
                camera_xyz=rr.ViewCoordinates.RDF,
                image_plane_distance=_FRUSTUM_M,
            ),
            static=True,
        )


def encode_png(image: Integer[np.ndarray, "h w"]) -> bytes:
    """Return an image of one channel as PNG.

    Among PNG's filters, the difference from the pixel above gives depth images the smallest files.
    It also encodes in half the time that choosing a filter row by row takes.

    Args:
        image: Pixels of 8 or 16 bits.
    """
    import cv2

    settings = [cv2.IMWRITE_PNG_COMPRESSION, 1, cv2.IMWRITE_PNG_FILTER, cv2.IMWRITE_PNG_FILTER_UP]
    return cv2.imencode(".png", image, settings)[1].tobytes()


def shown_depth_m(depth_m: Float[np.ndarray, "h w"]) -> float:
    """Return the least of some round depths within which nearly all seen points lie.

    Args:
        depth_m: Depth image; pixels without a reading are infinite or NaN.

    Returns:
        Depth of the last colour, in m; the greatest one for an image without any reading.
    """
    seen_m = depth_m[np.isfinite(depth_m)]
    far_m = float(np.quantile(seen_m, _NEARLY_ALL)) if len(seen_m) else math.inf
    return next((depth for depth in _SHOWN_DEPTHS_M if depth >= far_m), _SHOWN_DEPTHS_M[-1])


def _class_names() -> dict[int, str]:
    """Return the names of the numbers in images of classes."""
    from flightsim.cameras.segmentation import CLASS_NAMES

    return dict(CLASS_NAMES)


def _instance_names(scene: Scene) -> dict[int, str]:
    """Return the names of the numbers in images of objects."""
    from flightsim.cameras.view import NO_OBJECT_ID
    from flightsim.environment.movers import MAX_MOVERS
    from flightsim.testbench.cfg import MAX_INSTANCES
    from flightsim.world import (
        FIRST_MATE_ID,
        FIRST_MOVER_ID,
        GROUND_ID,
        NEIGHBOUR_ID,
        VEHICLE_ID,
    )

    others = {NO_OBJECT_ID: "sky", GROUND_ID: "bare ground", VEHICLE_ID: "own vehicle"}
    others[NEIGHBOUR_ID] = "surroundings"
    others |= {FIRST_MOVER_ID - index: f"mover {index}" for index in range(MAX_MOVERS)}
    others |= {FIRST_MATE_ID - k: f"vehicle {k + 1}" for k in range(MAX_INSTANCES)}
    # Negative ids wrap around as they do in the images.
    return {obj.id: f"{obj.category} {obj.id}" for obj in scene.objects} | {
        number % (1 << 16): name for number, name in others.items()
    }
