"""Topics that never change: fixed transforms and landing areas."""

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
    """Publish fixed transforms and landing areas once; late subscribers still get them.

    Args:
        parts: Topics and airframe of each vehicle.
        scene: Scene whose areas are published as markers.
    """
    first, _ = parts[0]
    ros = first.ros
    placed = []
    for topics, airframe in parts:
        # The estimate does not jump, so `map` and `odom` are the same place.
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
    # One message for all vehicles: only the last message is kept for late subscribers.
    first.publisher("/tf_static", "tf2_msgs/TFMessage", LATCHED).send(ros.transforms(*placed))
    markers = area_markers(ros, ros.header(0, MAP), scene.interaction_areas)
    first.publisher("/landing_areas", "visualization_msgs/MarkerArray", LATCHED).send(markers)


def _wxyz(mount: CameraMount) -> Sequence[float]:
    """Return the rotation of a camera's optical frame in the body, w first."""
    turn = Rotation.from_matrix(mount.rotation_flu_from_optical)
    return turn.as_quat(scalar_first=True).tolist()
