"""Offboard setpoints in every frame, with every mask, and sticks."""

import math

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from autonomy.types import ControlLevel
from flightsim.autopilot.modes import Mode
from flightsim.mavlink.dialect import dialect as mav
from tests.flightsim.mavlink.conftest import START_ENU_M

_POSITION = 0b1111_1111_1000 & ~(1 << 9) & ~(1 << 10)
_VELOCITY = 0b1101_1100_0111 & ~(1 << 10)
_ALL_IGNORED = 0b1101_1111_1111
_OFFBOARD = (1, 6, 0)


class _Recorder:
    """The last setpoint that reached the autopilot."""

    def __init__(self, flight, monkeypatch):
        self.flight = flight
        self.setpoint = None
        stream = flight.autopilot._flight.offboard
        monkeypatch.setattr(stream, "receive", lambda setpoint, _: self._take(setpoint))

    def _take(self, setpoint):
        self.setpoint = setpoint

    def send(self, name, *values):
        self.setpoint = None
        self.flight.send(name, *values)
        self.flight.step()
        return self.setpoint

    def local(self, mask, *, frame=1, p=(0, 0, 0), v=(0, 0, 0), a=(0, 0, 0), yaw=0, rate=0):
        values = (0, 1, 1, frame, mask, *p, *v, *a, yaw, rate)
        return self.send("SET_POSITION_TARGET_LOCAL_NED", *values)


@pytest.fixture
def recorder(flight, monkeypatch):
    flight.become_ready()
    return _Recorder(flight, monkeypatch)


def test_a_local_position_is_relative_to_the_start(recorder):
    setpoint = recorder.local(_POSITION, p=(3.0, 2.0, -5.0), yaw=0.5)
    x, y, z = setpoint.position_enu_m
    start = recorder.flight.server._view.origin_enu_m
    assert (x, y, z) == pytest.approx((start[0] + 2.0, start[1] + 3.0, start[2] + 5.0))
    assert start[:2] == pytest.approx(START_ENU_M[:2], abs=0.01)
    assert setpoint.yaw_rad == pytest.approx(math.pi / 2 - 0.5)
    assert all(map(math.isnan, setpoint.velocity_enu_mps + setpoint.acceleration_enu_mps2))


def test_offsets_are_relative_to_the_vehicle(recorder):
    x, y, z = recorder.flight.plant.estimate.position_enu_m
    setpoint = recorder.local(_POSITION, frame=7, p=(3.0, 2.0, -5.0))
    assert setpoint.position_enu_m == pytest.approx((x + 2.0, y + 3.0, z + 5.0), abs=0.05)


@pytest.mark.parametrize("frame", [9, 12])
def test_body_offsets_go_along_the_heading(recorder, frame):
    x, y, z = recorder.flight.plant.estimate.position_enu_m
    setpoint = recorder.local(_POSITION, frame=frame, p=(10.0, 0.0, -1.0))
    yaw_enu = 0.7
    expected = (x + 10 * math.cos(yaw_enu), y + 10 * math.sin(yaw_enu), z + 1.0)
    assert setpoint.position_enu_m == pytest.approx(expected, abs=0.5)


@pytest.mark.parametrize("frame", [8, 9, 12])
def test_body_velocities_go_along_the_heading(recorder, frame):
    setpoint = recorder.local(_VELOCITY, frame=frame, v=(0.0, 4.0, -1.0))
    yaw_enu = 0.7
    right = (4 * math.sin(yaw_enu), -4 * math.cos(yaw_enu), 1.0)
    assert setpoint.velocity_enu_mps == pytest.approx(right, abs=0.2)
    assert all(map(math.isnan, setpoint.position_enu_m))


@given(mask=st.integers(0, 0x1FF))
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=40)
def test_each_bit_of_the_mask_frees_its_axis(recorder, mask):
    setpoint = recorder.local(
        mask | 1 << 10 | 1 << 11, p=(1, 2, -3), v=(4, 5, -6), a=(7, 8, -9), yaw=1.0, rate=2.0
    )
    if mask == 0x1FF:
        assert setpoint is None
        return
    ned = []
    for vector in (
        recorder.flight.server._view.ned_from_enu(setpoint.position_enu_m),
        (setpoint.velocity_enu_mps[1], setpoint.velocity_enu_mps[0], -setpoint.velocity_enu_mps[2]),
        tuple(setpoint.acceleration_enu_mps2[i] * (-1 if i == 2 else 1) for i in (1, 0, 2)),
    ):
        ned += vector
    for bit, (value, sent) in enumerate(zip(ned, (1, 2, -3, 4, 5, -6, 7, 8, -9), strict=True)):
        assert math.isnan(value) if mask & 1 << bit else value == pytest.approx(sent)
    assert math.isnan(setpoint.yaw_rad)
    assert setpoint.yaw_rate_radps == 0.0


def test_a_yaw_rate_turns_clockwise(recorder):
    setpoint = recorder.local(_VELOCITY & ~(1 << 11) | 1 << 10, rate=0.6)
    assert setpoint.yaw_rate_radps == pytest.approx(-0.6)
    assert math.isnan(setpoint.yaw_rad)


@pytest.mark.parametrize(
    "values",
    [
        {"mask": _ALL_IGNORED},
        {"mask": _POSITION, "p": (math.nan,) * 3},
        {"mask": _POSITION, "p": (math.inf, 0, 0)},
        {"mask": _POSITION, "p": (1e30, 0, 0)},
        {"mask": _VELOCITY, "v": (0, -1e4, 0)},
        {"mask": _POSITION, "p": (1, 1, 1), "yaw": math.inf},
        {"mask": _VELOCITY & ~(1 << 11), "rate": 1e9},
        {"mask": _POSITION, "p": (1, 1, 1), "frame": 3},
        {"mask": _POSITION, "p": (1, 1, 1), "frame": 200},
        {"mask": 0b0010_0011_1111, "a": (1, 1, 1)},
    ],
)
def test_what_makes_no_sense_is_no_setpoint(recorder, values):
    assert recorder.local(**values) is None


@pytest.mark.parametrize(("frame", "height"), [(5, 500.0), (6, 12.0), (11, 12.0)])
def test_global_positions_are_above_sea_home_or_terrain(recorder, frame, height):
    recorder.flight.run(0.5)
    place = recorder.flight.frame.geodetic_from_enu((20.0, 30.0, 12.0))
    latitude, longitude = round(place.latitude_deg * 1e7), round(place.longitude_deg * 1e7)
    setpoint = recorder.send(
        "SET_POSITION_TARGET_GLOBAL_INT",
        *(0, 1, 1, frame, _POSITION, latitude, longitude, height),
        *(0.0,) * 8,
    )
    assert setpoint.position_enu_m == pytest.approx((20.0, 30.0, 12.0), abs=0.5)


def test_global_setpoints_in_local_frames_are_none(recorder):
    values = (0, 1, 1, 1, _POSITION, 0, 0, 5.0, *(0.0,) * 8)
    assert recorder.send("SET_POSITION_TARGET_GLOBAL_INT", *values) is None


def test_attitudes_and_rates(recorder):
    level_north = (1.0, 0.0, 0.0, 0.0)
    setpoint = recorder.send("SET_ATTITUDE_TARGET", 0, 1, 1, 7, level_north, 0, 0, 0, 0.6)
    assert (setpoint.level, setpoint.thrust) == (ControlLevel.ATTITUDE, pytest.approx(0.6))
    half = math.sqrt(0.5)
    assert setpoint.quat_wxyz == pytest.approx((half, 0.0, 0.0, half), abs=1e-6)
    setpoint = recorder.send("SET_ATTITUDE_TARGET", 0, 1, 1, 128, (0,) * 4, 0.1, 0.2, 0.3, 0.5)
    assert setpoint.level is ControlLevel.RATE
    assert setpoint.angular_rate_flu_radps == pytest.approx((0.1, -0.2, -0.3))


@pytest.mark.parametrize(
    ("mask", "quat", "rates", "thrust"),
    [
        (7, (0, 0, 0, 0), (0, 0, 0), 0.5),
        (7, (math.nan, 0, 0, 0), (0, 0, 0), 0.5),
        (7, (math.inf, 0, 0, 0), (0, 0, 0), 0.5),
        (7, (1, 0, 0, 0), (0, 0, 0), math.nan),
        (7 | 64, (1, 0, 0, 0), (0, 0, 0), 0.5),
        (128, (1, 0, 0, 0), (0, 1e6, 0), 0.5),
    ],
)
def test_attitudes_that_make_no_sense_are_no_setpoints(recorder, mask, quat, rates, thrust):
    assert recorder.send("SET_ATTITUDE_TARGET", 0, 1, 1, mask, quat, *rates, thrust) is None


def test_thrust_is_kept_between_nothing_and_everything(recorder):
    for sent, kept in ((-0.5, 0.0), (7.0, 1.0)):
        values = (0, 1, 1, 7, (1, 0, 0, 0), 0, 0, 0, sent)
        assert recorder.send("SET_ATTITUDE_TARGET", *values).thrust == kept


def test_offboard_is_refused_without_a_stream_and_left_when_it_stops(flight):
    flight.become_ready()
    assert flight.command(mav.MAV_CMD_DO_SET_MODE, *_OFFBOARD) == 1
    flight.command(mav.MAV_CMD_COMPONENT_ARM_DISARM, 1)

    def stream(seconds, z):
        for _ in range(round(seconds * 10)):
            values = (0, 1, 1, 1, _POSITION, 0, 0, z, 0, 0, 0, 0, 0, 0, 0, 0)
            flight.send("SET_POSITION_TARGET_LOCAL_NED", *values)
            flight.step(5)

    stream(0.5, -4.0)
    assert flight.command(mav.MAV_CMD_DO_SET_MODE, *_OFFBOARD) == 0
    stream(8.0, -4.0)
    assert flight.autopilot.mode is Mode.OFFBOARD
    assert flight.plant.truth.position_enu_m[2] == pytest.approx(4.2, abs=0.5)
    target = flight.last("POSITION_TARGET_LOCAL_NED")
    assert (target.x, target.y, target.z) == pytest.approx((0.0, 0.0, -4.0), abs=0.01)
    flight.run(3.0)
    assert flight.autopilot.mode is not Mode.OFFBOARD
    assert flight.autopilot.is_armed


def test_sticks_fly_in_position_mode(flight):
    flight.take_off()
    x, y, _ = flight.plant.truth.position_enu_m
    for step in range(100):
        flight.send("MANUAL_CONTROL", 1, 800, 0, 500, 0, 0)
        if step == 5:
            assert flight.command(mav.MAV_CMD_DO_SET_MODE, 1, 3, 0) == 0
        flight.step(2)
    truth = flight.plant.truth.position_enu_m
    ahead = (truth[0] - x) * math.cos(0.7) + (truth[1] - y) * math.sin(0.7)
    assert ahead > 3.0


@pytest.fixture
def sticks_taken(flight, monkeypatch):
    """Stick positions that reached the autopilot: pitch, roll, throttle, yaw."""
    taken = []
    monkeypatch.setattr(
        flight.autopilot,
        "set_manual_control",
        lambda *, pitch, roll, throttle, yaw: taken.append((pitch, roll, throttle, yaw)),
    )
    return taken


@pytest.mark.parametrize(
    ("name", "values", "expected"),
    [
        ("MANUAL_CONTROL", (1, 1000, -500, 250, 100, 0), (1.0, -0.5, 0.25, 0.1)),
        ("MANUAL_CONTROL", (1, 32767, 32767, 32767, 32767, 0), (0.0, 0.0, 0.5, 0.0)),
        ("MANUAL_CONTROL", (1, -32768, 9999, -9999, 0, 0), (-1.0, 1.0, 0.0, 0.0)),
        ("MANUAL_CONTROL", (7, 1000, 0, 0, 0, 0), None),
        ("RC_CHANNELS_OVERRIDE", (1, 1, 1600, 1400, 2000, 1500, 0, 0, 0, 0), (0.2, 0.2, 1.0, 0.0)),
        ("RC_CHANNELS_OVERRIDE", (1, 1, 0, 0, 0, 0, 0, 0, 0, 0), None),
        ("RC_CHANNELS_OVERRIDE", (1, 1, 65535, 65535, 65535, 65535, 0, 0, 0, 0), None),
        # As MAVProxy's "rc 3 1600" and DroneKit's overrides send it: the others are in the middle.
        ("RC_CHANNELS_OVERRIDE", (1, 1, 0, 0, 1600, 0, 0, 0, 0, 0), (0.0, 0.0, 0.6, 0.0)),
        ("RC_CHANNELS_OVERRIDE", (1, 1, 1400, 65535, 65535, 65535, 0, 0, 0, 0), (0, -0.2, 0.5, 0)),
    ],
)
def test_sticks_are_scaled_and_cut(flight, sticks_taken, name, values, expected):
    flight.send(name, *values)
    flight.step()
    assert sticks_taken == ([] if expected is None else [pytest.approx(expected)])


def test_an_overridden_channel_is_kept_until_it_is_released_or_old(flight, sticks_taken):
    kept, released = 65535, 0

    def send(*pulses):
        flight.send("RC_CHANNELS_OVERRIDE", 1, 1, *pulses, 0, 0, 0, 0)
        flight.step()
        return sticks_taken[-1]

    assert send(1600, kept, 1700, kept) == pytest.approx((0.0, 0.2, 0.7, 0.0))
    assert send(kept, kept, kept, 1400) == pytest.approx((0.0, 0.2, 0.7, -0.2))
    assert send(released, kept, kept, kept) == pytest.approx((0.0, 0.0, 0.7, -0.2))
    flight.run(0.4)
    assert send(kept, kept, 1600, kept) == pytest.approx((0.0, 0.0, 0.6, -0.2))
    flight.run(0.4)
    assert send(kept, 1500, kept, kept) == pytest.approx((0.0, 0.0, 0.6, 0.0))
