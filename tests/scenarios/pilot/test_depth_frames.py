"""Depth frames become posed images; one that shows nothing is refused with words."""

import dataclasses
import math

import numpy as np
import pytest

from flightsim.mavlink.client.telemetry import Telemetry
from flightsim.vehicles.catalogue import AIRFRAMES
from scenarios.pilot.depth_frames import NoDepthError, camera_mount, may_show, posed_image


@dataclasses.dataclass
class Frame:
    depth_m: np.ndarray
    fx: float = 100.0
    fy: float = 100.0
    cx: float = 3.5
    cy: float = 2.5


DOWN = camera_mount(AIRFRAMES["iris"], "down")
HERE = Telemetry(position_enu_m=(1.0, 2.0, 5.0), quat_wxyz=(1.0, 0.0, 0.0, 0.0))


def test_a_camera_that_looks_down_is_posed_below_the_vehicle():
    image = posed_image(Frame(np.full((6, 8), 4.0, np.float32)), DOWN, HERE)
    offset = np.subtract(image.position_enu_m, HERE.position_enu_m)
    np.testing.assert_allclose(offset, DOWN.position_flu_m, atol=1e-9)
    np.testing.assert_allclose(image.rotation_enu_from_optical[:, 2], (0, 0, -1), atol=1e-9)


@pytest.mark.parametrize("nothing", [math.inf, math.nan, 0.0])
def test_an_image_without_a_measured_pixel_is_named(nothing):
    frame = Frame(np.full((6, 8), nothing, np.float32))
    with pytest.raises(NoDepthError, match="camera down measured none of 8 x 6 pixels; valid: a s"):
        posed_image(frame, DOWN, HERE)
    frame.depth_m[3, 3] = 2.0
    assert posed_image(frame, DOWN, HERE).depth_m is frame.depth_m


def test_a_mover_may_be_shown_by_the_cameras_towards_it_alone():
    airframe = AIRFRAMES["iris"]
    # At 10 m height, heading north.
    state = Telemetry(
        position_enu_m=(0.0, 0.0, 10.0), quat_wxyz=(math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5))
    )

    def showing(*place):
        points = np.array([place])
        names = ("forward", "down", "up_left", "up_right", "up_rear")
        mounts = [camera_mount(airframe, name) for name in names]
        return {m.name for m in mounts if may_show(m, 4 / 3, state, points, 1.0)}

    assert showing(0.0, 8.0, 9.0) >= {"forward"}
    assert "up_rear" not in showing(0.0, 8.0, 9.0)
    assert showing(0.0, 0.0, 2.0) == {"down"}
    assert showing(0.0, -8.0, 12.0) == {"up_rear"}
    assert "up_left" in showing(-6.0, 2.0, 13.0)
    assert "up_right" not in showing(-6.0, 2.0, 13.0)
    # Its middle is out of view, a part of it is not.
    edge = 8.0 * math.tan(math.radians(15.0))
    assert "forward" in showing(0.0, 8.0, 10.0 + edge + 0.6)
    assert "forward" not in showing(0.0, 8.0, 10.0 + edge + 2.0)
