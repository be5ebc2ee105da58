"""Topics of what never changes: fixed transforms and landing areas."""

from __future__ import annotations

from collections.abc import Sequence

from scipy.spatial.transform import Rotation

from aeroscene.scene import Scene
from flightsim.vehicles import Airframe, CameraMount
from scenarios.ros2.frames import BASE, MAP, ODOM, optical
from scenarios.ros2.places import area_markers
from scenarios.ros2.topics import Topics
from scenarios.ros2.transport import LATCHED


def announce(parts: Sequence[tuple[Topics, Airframe]], scene: Scene) -> None:
    """Publish what is fixed, once: who subscribes late still gets it.

    Args:
        parts: Topics and airframe of each vehicle.
        scene: The scene.
    """
    first, _ = parts[0]
    ros = first.ros
    placed = []
    for topics, airframe in parts:
        origin = ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0))
        placed.append((ros.header(0, MAP), topics.frame(ODOM), *origin))
        header = ros.header(0, topics.frame(BASE))
        placed += [
            (
                header,
                optical(mount.name, topics.prefix),
                mount.position_flu_m,
                _wxyz(mount),
            )
            for mount in airframe.rgbd_cameras
        ]
    first.publisher("/tf_static", "tf2_msgs/TFMessage", LATCHED).send(ros.transforms(*placed))
    markers = area_markers(ros, ros.header(0, MAP), scene.interaction_areas)
    first.publisher("/landing_areas", "visualization_msgs/MarkerArray", LATCHED).send(markers)


def _wxyz(mount: CameraMount) -> Sequence[float]:
    """Rotation of a camera's optical frame in the body."""
    turn = Rotation.from_matrix(mount.rotation_flu_from_optical)
    return turn.as_quat(scalar_first=True).tolist()
