"""Cameras by option: what they change, and what is refused."""

import math

import mujoco
import numpy as np
import pytest

from flightsim.cameras.view import PoseCopy
from flightsim.testbench import TestbenchCfg, TestbenchError
from flightsim.vehicles import AIRFRAMES, AirframeError
from flightsim.vehicles.camera_options import with_cameras
from flightsim.world import build_world
from tests.flightsim.handmade import empty_scene

IRIS = AIRFRAMES["iris"]


def test_what_an_option_does_not_say_stays():
    assert with_cameras(IRIS, ()) == IRIS
    forward, down, *_ = with_cameras(IRIS, ("forward,fov=90,pitch=-10",)).cameras
    assert math.degrees(forward.vertical_fov_rad) == pytest.approx(90.0)
    assert math.degrees(forward.pitch_down_rad) == pytest.approx(-10.0)
    assert forward.position_flu_m == IRIS.cameras[0].position_flu_m
    assert down == IRIS.cameras[1]


def test_a_camera_of_ones_own_looks_where_it_should():
    airframe = with_cameras(IRIS, ("left,yaw=90,pitch=30,x=0.1,y=0.2,z=0.05",))
    assert [mount.name for mount in airframe.cameras][-2:] == ["up_rear", "left"]
    world = build_world(empty_scene(), airframe)
    poses = PoseCopy(world.model)
    data = world.new_data()
    data.qpos[:7] = (0.0, 0.0, 5.0, 1.0, 0.0, 0.0, 0.0)
    mujoco.mj_forward(world.model, data)
    poses.update(data)
    view = poses.viewpoint("left")
    np.testing.assert_allclose(view.position_enu_m, (0.1, 0.2, 5.05))
    right, down, forward = view.rotation_enu_from_optical.T
    np.testing.assert_allclose(forward, (0.0, math.cos(math.pi / 6), -0.5), atol=1e-12)
    np.testing.assert_allclose(right, (1.0, 0.0, 0.0), atol=1e-12)
    np.testing.assert_allclose(np.cross(forward, right), down, atol=1e-12)
    np.testing.assert_allclose(
        airframe.cameras[-1].rotation_flu_from_optical, view.rotation_enu_from_optical, atol=1e-12
    )


@pytest.mark.parametrize(
    ("option", "line"),
    [
        ("forward,fov=130", "fov is '130'; valid: 10 to 120 degrees from top to bottom"),
        ("forward,fov=wide", "fov is 'wide'; valid: 10 to 120"),
        ("forward,roll=1", "'roll=1' is unknown; valid: fov=, pitch=, yaw=, x=, y=, z="),
        ("forward,pitch=nan", "pitch is 'nan'; valid: -90 to 90 degrees down"),
        ("down,z=-0.5", "z is -0.5; valid: above the ground, more than -0.11 m"),
        ("my cam,fov=60", "begins with 'my cam'; valid: a name"),
    ],
)
def test_a_bad_option_is_refused_in_one_line(option, line):
    with pytest.raises(AirframeError) as error:
        TestbenchCfg(camera=(option,))
    assert str(error.value).startswith(f"camera {option!r}")
    assert line in str(error.value)


@pytest.mark.parametrize("size", ["640", "640x", "15x480", "640x5000", "axb", "-64x48"])
def test_a_bad_size_is_refused_in_one_line(size):
    with pytest.raises(TestbenchError, match=r"valid: WIDTHxHEIGHT of 16 to 4096 pixels"):
        TestbenchCfg(camera_size=size)
