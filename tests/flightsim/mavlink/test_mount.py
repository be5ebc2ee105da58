"""The gimbal by the messages of older clients, and what they read of it."""

import math

import pytest

from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.personalities import ARDUPILOT, PX4
from flightsim.payload import PayloadCfg
from tests.flightsim.mavlink.conftest import Flight
from tests.flightsim.mavlink.wire import named

_NEUTRAL, _ANGLES, _RC, _PLACE, _HOME = 1, 2, 3, 4, 6


@pytest.fixture(params=[ARDUPILOT, PX4], ids=lambda stack: stack.name)
def laden(field, request):
    flight = Flight(field, request.param, payload=PayloadCfg())
    flight.send("HEARTBEAT", 6, 8, 0, 0, 4, 3)
    flight.step()
    yield flight
    flight.close()


def _pitch_yaw_deg(flight):
    gimbal = flight.payload.gimbal
    return -math.degrees(gimbal.pitch_down_rad), -math.degrees(gimbal.yaw_rad)


def _texts(flight):
    return "".join(m.text for m in named(flight.heard, "STATUSTEXT"))


def test_mount_control_turns_the_gimbal_and_older_clients_read_where_it_points(laden):
    laden.send("MOUNT_CONFIGURE", 0, 1, _ANGLES, 1, 1, 1)
    laden.send("MOUNT_CONTROL", 0, 1, -4000, 0, 2500, 0)
    laden.run(2.0)
    assert _pitch_yaw_deg(laden) == pytest.approx((-40.0, 25.0), abs=0.1)
    is_ours = laden.server.telemetry.is_known
    if is_ours(158):  # MOUNT_STATUS streams by itself.
        status = laden.last("MOUNT_STATUS")
        assert (status.pointing_a, status.pointing_c) == pytest.approx((-4000, 2500), abs=10)
        assert status.mount_mode == _ANGLES
    else:
        assert laden.command(mav.MAV_CMD_REQUEST_MESSAGE, 265) == mav.MAV_RESULT_ACCEPTED
        told = laden.last("MOUNT_ORIENTATION")
        assert (told.pitch, told.roll, told.yaw) == pytest.approx((-40.0, 0.0, 25.0), abs=0.1)


def test_a_mount_looks_at_a_place_and_at_home(laden):
    laden.become_ready()
    home = laden.autopilot.home.geodetic
    laden.send("MOUNT_CONFIGURE", 1, 1, _PLACE, 0, 0, 0)
    north = round((home.latitude_deg + 1e-3) * 1e7)
    laden.send("MOUNT_CONTROL", 1, 1, north, round(home.longitude_deg * 1e7), 0, 0)
    laden.run(4.0)
    heading_deg = laden.server._view.heading_deg
    _, yaw_deg = _pitch_yaw_deg(laden)
    assert (yaw_deg + heading_deg) % 360.0 == pytest.approx(0.0, abs=1.0) or (
        (yaw_deg + heading_deg) % 360.0 == pytest.approx(360.0, abs=1.0)
    )
    laden.send("MOUNT_CONFIGURE", 1, 1, _NEUTRAL, 0, 0, 0)
    laden.run(4.0)
    assert _pitch_yaw_deg(laden) == pytest.approx((0.0, 0.0), abs=0.1)
    assert laden.command(mav.MAV_CMD_DO_MOUNT_CONFIGURE, _HOME) == mav.MAV_RESULT_ACCEPTED


def test_what_the_mount_does_not_do_is_said(laden):
    laden.send("MOUNT_CONFIGURE", 0, 1, _RC, 1, 1, 1)
    laden.step(3)
    assert "MOUNT_CONFIGURE denied: mount mode 3; valid are 0, 1" in _texts(laden)
    assert laden.command(mav.MAV_CMD_DO_MOUNT_CONFIGURE, _RC) == mav.MAV_RESULT_DENIED
    laden.send("MOUNT_CONFIGURE", 0, 1, _NEUTRAL, 1, 1, 1)
    laden.send("MOUNT_CONTROL", 0, 1, -4000, 0, 0, 0)
    laden.run(1.0)
    assert "MOUNT_CONTROL denied: the mount is in mode 1" in _texts(laden)
    assert _pitch_yaw_deg(laden) == (0.0, 0.0)


def test_digicam_control_takes_a_picture(laden):
    laden.send("DIGICAM_CONTROL", 1, 1, 0, 0, 0, 0, 1, 0, 0, 0.0)
    laden.run(0.5)
    assert laden.payload.camera.n_taken == 1
    laden.send("DIGICAM_CONTROL", 1, 1, 0, 3, 0, 0, 0, 0, 0, 0.0)
    laden.step(3)
    assert "DIGICAM_CONTROL denied: zoom and focus are fixed" in _texts(laden)
