"""Topics of a vehicle's cameras, which render only while somebody subscribes.

Rendering is by far the most expensive part of the door. A camera nobody listens to costs nothing.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from flightsim.cameras import RgbdFrame
from flightsim.plant import Plant
from flightsim.simulator import TICK_US
from flightsim.stored_depth import depth_to_uint16
from scenarios.ros2.frames import optical
from scenarios.ros2.images import camera_info, depth_cloud, image
from scenarios.ros2.topics import Topics
from scenarios.ros2.transport import SENSOR

_IMAGE, _INFO = "sensor_msgs/Image", "sensor_msgs/CameraInfo"
_KINDS = {"rgb": "rgb8", "depth": "16UC1", "classes": "mono8", "instances": "mono16"}
"""Encoding of each kind of image."""


class CameraTopics:
    """Publishes the images, the lens and the depth points of one camera."""

    def __init__(
        self,
        topics: Topics,
        plant: Plant,
        camera: str,
        render: Callable[[str], RgbdFrame],
        *,
        rate_hz: float,
        has_segments: bool,
    ) -> None:
        """Offer the topics of a camera.

        Args:
            topics: Topics of the vehicle.
            plant: The vehicle.
            camera: Name of the camera.
            render: Function that renders the present frame of a camera by name.
            rate_hz: Frames in a simulated second, greater than 0.
            has_segments: True if frames have objects and classes, which then get topics too.
        """
        self._ros, self._plant, self._camera, self._render = topics.ros, plant, camera, render
        self._period_us = round(1e6 / rate_hz)
        self._frame = optical(camera, topics.prefix)
        kinds = ("rgb", "depth", "classes", "instances") if has_segments else ("rgb", "depth")
        stem = f"camera_{camera}"
        self._images = {
            kind: topics.publisher(f"{stem}/{kind}/image_raw", _IMAGE, SENSOR) for kind in kinds
        }
        self._infos = [
            topics.publisher(f"{stem}/{kind}/camera_info", _INFO, SENSOR) for kind in kinds
        ]
        self._points = topics.publisher(f"{stem}/depth/points", "sensor_msgs/PointCloud2", SENSOR)

    def on_tick(self) -> None:
        """Render and publish if a frame is due and anybody listens.

        Frames are due at the same times as in a recording, so that both have the same images.
        """
        # The first tick at or after each multiple of the period; ticks are 20 ms apart.
        if self._plant.time_us % self._period_us >= TICK_US:
            return
        if any(each.is_heard for each in (*self._images.values(), *self._infos, self._points)):
            self._send(self._render(self._camera))

    def _send(self, frame: RgbdFrame) -> None:
        ros = self._ros
        header = ros.header(frame.time_us, self._frame)
        lens = (float(frame.fx), float(frame.fy), float(frame.cx), float(frame.cy))
        height, width = frame.depth_m.shape
        for kind, publisher in self._images.items():
            # Images are large: one that nobody hears is not even encoded.
            if publisher.is_heard:
                publisher.send(image(ros, header, _pixels(frame, kind), _KINDS[kind]))
        for publisher in self._infos:
            publisher.offer(lambda: camera_info(ros, header, (width, height), lens))
        self._points.offer(lambda: depth_cloud(ros, header, frame.depth_m, lens))


def _pixels(frame: RgbdFrame, kind: str) -> np.ndarray:
    """Return the pixels of a kind of image, in the same numbers as in recordings."""
    if kind == "rgb":
        return frame.rgb
    if kind == "depth":
        return depth_to_uint16(frame.depth_m)
    assert frame.class_ids is not None
    assert frame.instance_ids is not None
    # Negative ids wrap around in unsigned numbers: -1 becomes 65535.
    return frame.class_ids if kind == "classes" else frame.instance_ids.astype(np.uint16)
