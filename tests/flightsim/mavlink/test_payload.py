"""Camera and gimbal over MAVLink: components, requests, pictures, pointing, missions."""

import json
import math
import random
import socket
from itertools import pairwise

import numpy as np
import pytest
from PIL import ExifTags, Image

from flightsim.frames import Geodetic
from flightsim.mavlink.dialect import LAYOUTS
from flightsim.mavlink.dialect import dialect as mav
from flightsim.payload import PayloadCfg
from tests.flightsim.mavlink.conftest import Flight
from tests.flightsim.mavlink.wire import Wire, named
from tests.instances import free_port

_CAMERA, _GIMBAL = 100, 154
_ACCEPTED, _REJECTED, _DENIED, _UNSUPPORTED = range(4)
_NAN = math.nan


@pytest.fixture
def laden(field):
    """A vehicle with its payload, whose client has already sent data."""
    flight = Flight(field, payload=PayloadCfg())
    flight.send("HEARTBEAT", 6, 8, 0, 0, 4, 3)
    flight.step()
    yield flight
    flight.close()


def _ask(flight, component, name, number=0.0):
    """Request a message and return it."""
    message_id = LAYOUTS[name].message_id
    flight.send("COMMAND_LONG", 1, component, 512, 0, message_id, number, 0, 0, 0, 0, 0)
    came = flight.step()
    (ack,) = named(came, "COMMAND_ACK")
    assert (ack.get_srcComponent(), ack.result) == (component, _ACCEPTED), name
    message, *_ = [m for m in named(came, name) if m.get_srcComponent() == component]
    return message


def test_the_components_introduce_themselves_to_whoever_tells_components_apart(laden):
    kinds = {_CAMERA: mav.MAV_TYPE_CAMERA, _GIMBAL: mav.MAV_TYPE_GIMBAL}
    beats = [m for m in named(laden.run(3.0), "HEARTBEAT") if m.get_srcComponent() != 1]
    assert sorted(m.get_srcComponent() for m in beats) == [_CAMERA] * 3 + [_GIMBAL] * 3
    assert all(m.type == kinds[m.get_srcComponent()] for m in beats)
    assert {m.autopilot for m in beats} == {mav.MAV_AUTOPILOT_INVALID}
    for wire in (Wire(is_version_1=True), Wire(component_id=0)):
        laden.wire = wire
        laden.send("HEARTBEAT", 6, 8, 0, 0, 4, 3)
        laden.step(2)
        assert {m.get_srcComponent() for m in laden.run(3.0)} == {1}


def test_each_component_numbers_its_own_messages(laden):
    _ask(laden, _GIMBAL, "GIMBAL_MANAGER_INFORMATION")
    laden.run(3.0)
    for component in (1, _CAMERA, _GIMBAL):
        numbers = [m.get_seq() for m in laden.heard if m.get_srcComponent() == component]
        steps = {(b - a) % 256 for a, b in pairwise(numbers)}
        assert steps == {1}, component


@pytest.mark.parametrize(
    ("name", "old"),
    [
        ("CAMERA_INFORMATION", 521),
        ("CAMERA_SETTINGS", 522),
        ("STORAGE_INFORMATION", 525),
        ("CAMERA_CAPTURE_STATUS", 527),
    ],
)
def test_the_camera_answers_new_and_old_requests_whoever_is_addressed(laden, name, old):
    asked = _ask(laden, _CAMERA, name)
    for component in (0, 1, _CAMERA):
        assert laden.command(old, component=component) == _ACCEPTED
        last = laden.last(name)
        assert last.get_srcComponent() == _CAMERA
        assert type(last) is type(asked)


def test_messages_come_at_intervals_to_who_asks(laden):
    message_id = LAYOUTS["CAMERA_CAPTURE_STATUS"].message_id
    assert laden.command(511, message_id, 200_000, component=_CAMERA) == _ACCEPTED
    assert len(named(laden.run(2.0), "CAMERA_CAPTURE_STATUS")) == 10
    assert laden.command(511, message_id, -1, component=_CAMERA) == _ACCEPTED
    assert not named(laden.run(1.0), "CAMERA_CAPTURE_STATUS")
    assert laden.command(511, 74, 200_000, component=_CAMERA) == _DENIED
    assert laden.command(512, LAYOUTS["VFR_HUD"].message_id, component=_CAMERA) == _DENIED
    beats = [m for m in named(laden.run(3.0), "HEARTBEAT") if m.get_srcComponent() == _CAMERA]
    assert len(beats) == 3


def test_without_a_folder_pictures_are_counted_and_told(laden):
    assert laden.command(2000, 0, 0, 1, component=_CAMERA) == _ACCEPTED
    laden.step(2)
    told = laden.last("CAMERA_IMAGE_CAPTURED")
    assert (told.image_index, told.capture_result, told.file_url.rstrip("\0")) == (0, 1, "")
    assert _ask(laden, _CAMERA, "CAMERA_CAPTURE_STATUS").image_count == 1
    assert _ask(laden, _CAMERA, "STORAGE_INFORMATION").status == mav.STORAGE_STATUS_NOT_SUPPORTED
    assert not laden.payload.lens.is_open


def test_photographs_are_files_with_their_pose(field, tmp_path):
    flight = Flight(field, payload=PayloadCfg(captures=tmp_path / "captures"))
    flight.become_ready()
    flight.send("COMMAND_LONG", 1, 1, 1000, 0, -30.0, 0.0, _NAN, _NAN, 0, 0, 0)
    flight.run(1.0)
    assert flight.command(2000, 0, 0, 1, component=_CAMERA) == _ACCEPTED
    flight.step(2)
    told = flight.last("CAMERA_IMAGE_CAPTURED")
    path = tmp_path / "captures" / told.file_url.rstrip("\0")
    with Image.open(path) as image:
        rgb = np.asarray(image)
        place = image.getexif().get_ifd(ExifTags.IFD.GPSInfo)
    assert rgb.shape == (960, 1280, 3)
    assert rgb.std() > 5.0
    d, m, s = place[ExifTags.GPS.GPSLatitude]
    assert abs(d + m / 60 + s / 3600 - told.lat * 1e-7) < 1e-6
    assert abs(told.lat * 1e-7 - flight.last("GLOBAL_POSITION_INT").lat * 1e-7) < 1e-5
    pose = json.loads(path.with_suffix(".json").read_text(encoding="utf-8"))
    w, x, y, z = pose["quat_wxyz_true"]
    assert math.isclose(2 * (w * y - z * x), 0.5, abs_tol=1e-6)  # 30 degrees down
    near_m = math.dist(pose["position_enu_m_true"], flight.plant.truth.position_enu_m)
    assert near_m < 0.3
    storage = _ask(flight, _CAMERA, "STORAGE_INFORMATION")
    n_bytes = sum(p.stat().st_size for p in path.parent.iterdir())
    assert math.isclose(storage.used_capacity, n_bytes / (1 << 20), rel_tol=1e-5)
    flight.close()


def test_an_order_is_acknowledged_before_its_picture_is_rendered(field, tmp_path, monkeypatch):
    flight = Flight(field, payload=PayloadCfg(captures=tmp_path))
    came = []

    def render(size):
        came.extend(flight.wire.decode(flight.link.client.recv()))
        raise OSError(f"no {size}")

    monkeypatch.setattr(flight.payload.lens, "render", render)
    flight.send("COMMAND_LONG", 1, _CAMERA, 2000, 0, 0, 0, 1, 0, 0, 0, 0)
    flight.simulator.step()
    (ack,) = named(came, "COMMAND_ACK")
    assert (ack.command, ack.result) == (2000, _ACCEPTED)
    flight.close()


def test_a_disk_that_refuses_costs_the_picture_alone(field, tmp_path):
    folder = tmp_path / "captures"
    flight = Flight(field, payload=PayloadCfg(captures=folder))
    flight.send("HEARTBEAT", 6, 8, 0, 0, 4, 3)
    folder.rmdir()
    folder.write_text("a file where the folder was", encoding="utf-8")
    flight.command(2000, 0, 0, 1, component=_CAMERA)
    flight.step(2)
    assert flight.last("CAMERA_IMAGE_CAPTURED").capture_result == 0
    assert flight.server.faults.n_caught == 0
    flight.close()


def test_series_can_be_counted_stopped_and_asked_for_again(laden):
    assert laden.command(2000, 0, 0.5, 3, component=_CAMERA) == _ACCEPTED
    assert laden.command(2000, 0, 0, 1, component=_CAMERA) == _REJECTED
    assert _ask(laden, _CAMERA, "CAMERA_CAPTURE_STATUS").image_status == 2
    laden.run(2.0)
    told = named(laden.heard, "CAMERA_IMAGE_CAPTURED")
    assert [m.image_index for m in told] == [0, 1, 2]
    assert [b.time_boot_ms - a.time_boot_ms for a, b in pairwise(told)] == [500, 500]
    assert laden.command(2000, 0, 1.0, 0, component=_CAMERA) == _ACCEPTED
    laden.run(1.5)
    assert laden.command(2001, component=_CAMERA) == _ACCEPTED
    laden.run(2.0)
    assert _ask(laden, _CAMERA, "CAMERA_IMAGE_CAPTURED", 1).image_index == 1
    assert laden.command(2002, 4, component=_CAMERA) == _ACCEPTED
    assert laden.command(2002, 5, component=_CAMERA) == _DENIED
    assert laden.command(2000, 0, 0.1, 5, component=_CAMERA) == _DENIED


def test_an_order_that_is_repeated_for_its_acknowledgement_is_one_order(laden):
    for sequence in (1, 1, 2):
        assert laden.command(2000, 0, 0, 1, sequence, component=_CAMERA) == _ACCEPTED
        laden.run(0.6)
    for _ in range(2):
        assert laden.command(2000, 0, 1.0, 2, component=_CAMERA) == _ACCEPTED
        laden.run(0.4)
    laden.run(2.0)
    told = named(laden.heard, "CAMERA_IMAGE_CAPTURED")
    assert [m.image_index for m in told] == [0, 1, 2, 3]


@pytest.mark.parametrize("number", [531, 532, 526, 529, 2004, 2010])
def test_what_the_camera_cannot_do_is_unsupported(laden, number):
    assert laden.command(number, 1, 1, component=_CAMERA) == _UNSUPPORTED


def test_films_and_modes_are_reported(laden):
    assert laden.command(530, 0, 1, component=_CAMERA) == _ACCEPTED
    assert _ask(laden, _CAMERA, "CAMERA_SETTINGS").mode_id == 1
    assert laden.command(530, 0, 2, component=_CAMERA) == _DENIED
    assert laden.command(2500, component=_CAMERA) == _ACCEPTED
    assert laden.command(2500, component=_CAMERA) == _REJECTED
    laden.run(1.0)
    status = _ask(laden, _CAMERA, "CAMERA_CAPTURE_STATUS")
    assert status.video_status == 1
    assert 1000 <= status.recording_time_ms <= 1200
    assert laden.command(2501, component=_CAMERA) == _ACCEPTED
    assert _ask(laden, _CAMERA, "CAMERA_CAPTURE_STATUS").video_status == 0
    assert laden.command(2502, 1, component=_CAMERA) == _DENIED
    flags = _ask(laden, _CAMERA, "CAMERA_INFORMATION").flags
    assert not flags & mav.CAMERA_CAP_FLAGS_HAS_VIDEO_STREAM


def test_a_stream_says_where_it_is(field):
    port = free_port(socket.SOCK_DGRAM)
    flight = Flight(field, payload=PayloadCfg(video_port=port))
    flight.send("HEARTBEAT", 6, 8, 0, 0, 4, 3)
    flight.payload.video._render = lambda: np.zeros((480, 640, 3), np.uint8)
    flight.step()
    stream = _ask(flight, _CAMERA, "VIDEO_STREAM_INFORMATION")
    assert stream.uri.rstrip("\0") == f"udp://127.0.0.1:{port}"
    assert (stream.resolution_h, stream.resolution_v, stream.framerate) == (640, 480, 10.0)
    assert (stream.type, stream.encoding, stream.flags) == (1, 1, 1)
    flight.run(0.5)
    n_bytes = flight.payload.video.n_bytes
    assert n_bytes
    assert flight.command(2503, 1, component=_CAMERA) == _ACCEPTED
    assert _ask(flight, _CAMERA, "VIDEO_STREAM_STATUS").flags == 0
    flight.run(0.5)
    assert flight.payload.video.n_bytes == n_bytes
    flight.close()


# --- the gimbal ---


def _attitude(flight):
    """Pitch and yaw of the gimbal as it reports them, in degrees."""
    m = _ask(flight, _GIMBAL, "GIMBAL_DEVICE_ATTITUDE_STATUS")
    w, x, y, z = m.q
    pitch = math.asin(max(-1.0, min(1.0, 2 * (w * y - z * x))))
    yaw = math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    return math.degrees(pitch), math.degrees(yaw)


def _point(flight, pitch, yaw, flags=12, component=_GIMBAL):
    params = (pitch, yaw, _NAN, _NAN, flags)
    return flight.command(1000, *params, component=component)


def test_the_gimbal_turns_and_reports_where_it_points(laden):
    laden.become_ready()
    information = _ask(laden, _GIMBAL, "GIMBAL_MANAGER_INFORMATION")
    assert information.gimbal_device_id == 1
    assert math.isclose(information.pitch_min, -math.pi / 2, rel_tol=1e-6)
    assert math.isclose(information.pitch_max, math.radians(30), rel_tol=1e-6)
    assert _ask(laden, _GIMBAL, "GIMBAL_DEVICE_INFORMATION").gimbal_device_id == 1
    for component in (1, _GIMBAL):
        assert _point(laden, -60.0, 90.0, component=component) == _ACCEPTED
        laden.run(2.0)
        assert _attitude(laden) == pytest.approx((-60.0, 90.0), abs=0.1)
        assert _point(laden, 0.0, 0.0, component=component) == _ACCEPTED
        laden.run(2.0)
    assert len(named(laden.run(1.0), "GIMBAL_DEVICE_ATTITUDE_STATUS")) == 10


def test_command_int_carries_its_flags_unscaled(laden):
    laden.become_ready()
    laden.command(1000, -10.0, 20.0, _NAN, _NAN, 12)
    flags = mav.GIMBAL_MANAGER_FLAGS_YAW_LOCK
    assert laden.command_int(1000, 3, -10.0, 20.0, _NAN, _NAN, flags, 0, 1) == _ACCEPTED
    assert laden.payload.gimbal.is_yaw_locked


def test_a_locked_gimbal_points_to_the_compass(laden):
    laden.become_ready()
    _point(laden, 0.0, 20.0, flags=12 | mav.GIMBAL_MANAGER_FLAGS_YAW_LOCK)
    laden.run(3.0)
    assert _attitude(laden) == pytest.approx((0.0, 20.0), abs=0.5)
    status = laden.last("GIMBAL_DEVICE_ATTITUDE_STATUS")
    assert status.flags & mav.GIMBAL_DEVICE_FLAGS_YAW_IN_EARTH_FRAME
    forward = laden.payload.lens.aim_est().quat_wxyz
    yaw_enu = math.degrees(2 * math.atan2(forward[3], forward[0]))
    assert (90.0 - yaw_enu) % 360.0 == pytest.approx(20.0, abs=0.5)


def test_who_is_in_control_keeps_others_out(laden):
    assert laden.command(1001, 255, 190, 0, 0, 0, 0, 1, component=_GIMBAL) == _ACCEPTED
    status = laden.last("GIMBAL_MANAGER_STATUS")
    assert (status.primary_control_sysid, status.primary_control_compid) == (255, 190)
    other = Wire(77, 1)
    frame = other.encode("COMMAND_LONG", 1, _GIMBAL, 1000, 0, -45, 0, _NAN, _NAN, 0, 0, 0)
    laden.link.client.send(frame)
    (ack,) = named(laden.step(), "COMMAND_ACK")
    assert ack.result == _DENIED
    turn = ("GIMBAL_MANAGER_SET_PITCHYAW", 1, _GIMBAL, 12, 1, -0.5, 0.0, _NAN, _NAN)
    laden.link.client.send(other.encode(*turn))
    laden.run(1.0)
    assert laden.payload.gimbal.pitch_down_rad == 0.0
    laden.send(*turn)
    laden.run(1.0)
    assert math.isclose(laden.payload.gimbal.pitch_down_rad, 0.5, rel_tol=1e-6)
    assert laden.command(1001, -3, -3, -3, -3, 0, 0, 1, component=_GIMBAL) == _ACCEPTED
    assert laden.last("GIMBAL_MANAGER_STATUS").primary_control_sysid == 0
    laden.link.client.send(frame)
    (ack,) = named(laden.step(), "COMMAND_ACK")
    assert ack.result == _ACCEPTED
    assert laden.command(1001, 255.5, 1, -1, -1, component=_GIMBAL) == _DENIED
    assert laden.command(1001, 999, 1, -1, -1, component=_GIMBAL) == _DENIED
    assert laden.command(1000, 0, 0, 0, 0, 0, 0, 9, component=_GIMBAL) == _DENIED


def test_messages_turn_it_by_attitude_rates_and_sticks(laden):
    laden.become_ready()
    half = math.radians(-20.0) / 2
    q = (math.cos(half), 0.0, math.sin(half), 0.0)
    attitude = ("GIMBAL_MANAGER_SET_ATTITUDE", 1, _GIMBAL, 12, 1)
    laden.send(*attitude, q, _NAN, _NAN, _NAN)
    laden.run(1.0)
    assert _attitude(laden)[0] == pytest.approx(-20.0, abs=0.1)
    laden.send(*attitude, (_NAN,) * 4, 0.0, math.radians(5.0), _NAN)
    laden.run(2.0)
    assert _attitude(laden)[0] == pytest.approx(-10.0, abs=0.3)
    sticks = ("GIMBAL_MANAGER_SET_MANUAL_CONTROL", 1, _GIMBAL, 12, 1)
    laden.send(*sticks, -1.0, _NAN, _NAN, -0.5)
    laden.run(2.0)
    assert _attitude(laden)[0] == pytest.approx(-90.0, abs=0.1)
    assert math.degrees(laden.payload.gimbal.yaw_rad) == pytest.approx(60.0, abs=2.0)
    laden.send(*sticks[:3], mav.GIMBAL_MANAGER_FLAGS_NEUTRAL, 1, _NAN, _NAN, _NAN, _NAN)
    laden.run(2.0)
    assert _attitude(laden) == pytest.approx((0.0, 0.0), abs=0.1)


def _looks_at(flight, target_enu_m):
    """Degrees between where the camera looks, truly, and a target."""
    aim = flight.payload.lens.aim_true()
    w, x, y, z = aim.quat_wxyz
    forward = np.array([1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)])
    to = np.array(target_enu_m) - aim.position_enu_m
    return math.degrees(math.acos(min(1.0, forward @ to / np.linalg.norm(to))))


def test_a_region_of_interest_is_looked_at_and_let_go(laden):
    laden.take_off(10.0)
    target_enu_m = (40.0, -30.0, 2.0)
    place = laden.frame.geodetic_from_enu(target_enu_m)
    x, y = round(place.latitude_deg * 1e7), round(place.longitude_deg * 1e7)
    ask = (0.0, _NAN, _NAN, _NAN, x, y)
    # An altitude above the sea, whatever the frame: what MAVSDK sends.
    assert laden.command_int(195, 3, *ask, place.altitude_m) == _ACCEPTED
    laden.skip(4.0)
    assert _looks_at(laden, target_enu_m) < 1.5
    assert laden.command_int(195, 3, *ask[:5], 0x7FFFFFFF, 500.0) == _DENIED
    assert laden.command(197) == _ACCEPTED
    laden.skip(3.0)
    assert laden.payload.gimbal.pitch_down_rad == laden.payload.gimbal.yaw_rad == 0.0


def _upload(flight, *items):
    """Upload a mission of (command, frame, seven parameters)."""
    flight.send("MISSION_COUNT", 1, 1, len(items))
    for seq, (command, frame, *params) in enumerate(items):
        flight.run_until(lambda: named(flight.heard, "MISSION_REQUEST_INT"), 2.0)
        flight.heard.clear()
        x, y = params[4:6]
        flight.send(
            *("MISSION_ITEM_INT", 1, 1, seq, frame, command, 0, 1, *params[:4]),
            *(round(x), round(y), params[6]),
        )
        flight.step()
    assert flight.last("MISSION_ACK").type == 0


def test_missions_trigger_the_camera_and_point_the_gimbal(laden):
    laden.become_ready()
    x0, y0, _ = laden.plant.truth.position_enu_m
    far = laden.frame.geodetic_from_enu((x0 + 32.0, y0, 0.0))
    aside_enu_m = (x0 + 10.0, y0 + 20.0, 0.0)
    aside = laden.frame.geodetic_from_enu(aside_enu_m)
    none = (_NAN,) * 3
    _upload(
        laden,
        (22, 3, 0.0, 0.0, 0.0, _NAN, 0, 0, 10.0),
        (195, 3, 0.0, 0.0, 0.0, 0.0, aside.latitude_deg * 1e7, aside.longitude_deg * 1e7, 0.0),
        (206, 2, 8.0, 0.0, 0.0, 0.0, 0, 0, 0.0),
        (16, 3, 0.0, 0.0, 0.0, _NAN, far.latitude_deg * 1e7, far.longitude_deg * 1e7, 10.0),
        (206, 2, 0.0, 0.0, 0.0, 0.0, 0, 0, 0.0),
        (2000, 2, 0.0, 0.0, 1.0, *none[:1], 0, 0, 0.0),
        (93, 2, 4.0, 0.0, 0.0, 0.0, 0, 0, 0.0),
        (1000, 2, -90.0, 0.0, _NAN, _NAN, 12, 0, 1.0),
        (17, 3, 0.0, 0.0, 0.0, _NAN, far.latitude_deg * 1e7, far.longitude_deg * 1e7, 10.0),
    )
    assert laden.command(mav.MAV_CMD_COMPONENT_ARM_DISARM, 1) == _ACCEPTED
    assert laden.command(mav.MAV_CMD_MISSION_START) == _ACCEPTED
    # Somebody else is in control: the vehicle's own mission acts all the same.
    assert laden.command(1001, 9, 9, 0, 0) == _ACCEPTED
    laden.run_until(lambda: laden.payload.camera.n_taken == 2, 40.0)
    assert _looks_at(laden, aside_enu_m) < 3.0
    laden.run_until(lambda: laden.autopilot.mission.current_index == 8, 60.0)
    laden.skip(2.0)
    assert math.isclose(laden.payload.gimbal.pitch_down_rad, math.pi / 2)
    told = named(laden.heard, "CAMERA_IMAGE_CAPTURED")
    places = [laden.frame.enu_from_geodetic(_place(m)) for m in told]
    assert len(told) == 4  # three by the way of 30 m, one by its item
    steps = [math.dist(a, b) for a, b in pairwise(places[:3])]
    assert steps == pytest.approx([8.0] * 2, abs=0.6)


def _place(m):
    return Geodetic(m.lat * 1e-7, m.lon * 1e-7, m.alt * 1e-3)


def test_the_flight_is_the_same_bit_for_bit_whatever_is_taken(field, tmp_path):
    ends = []
    for cfg in (None, PayloadCfg(captures=tmp_path)):
        flight = Flight(field, payload=cfg)
        flight.take_off(5.0)
        if cfg is not None:
            flight.send("COMMAND_LONG", 1, 1, 2000, 0, 0, 0, 1, 0, 0, 0, 0)
            flight.send("COMMAND_LONG", 1, 1, 1000, 0, -90, 0, _NAN, _NAN, 0, 0, 0)
        flight.skip(2.0)
        ends.append(flight.plant.truth)
        flight.close()
    assert ends[0] == ends[1]
    assert len(list(tmp_path.iterdir())) == 2


_EXTREMES = (0.0, 1.0, -1.0, -3.0, 255.0, 3.5, _NAN, 1e30, -1e30, 3.4e38)


def test_nothing_that_the_components_are_told_is_a_fault(laden):
    rng = random.Random(5)
    laden.become_ready()
    numbers = sorted(laden.server._payload.executors) + [510, 512]
    for number in numbers:
        for component in (1, _CAMERA, _GIMBAL):
            for _ in range(6):
                params = [rng.choice(_EXTREMES) for _ in range(7)]
                laden.send("COMMAND_LONG", 1, component, number, 0, *params)
            xy = [rng.choice([0, 1, -1, 0x7FFFFFFF, -0x80000000]) for _ in range(2)]
            frame = rng.choice([0, 1, 2, 3, 10, 255])
            laden.send(
                "COMMAND_INT", 1, component, frame, number, 0, 0, *params[:4], *xy, params[6]
            )
            laden.step()
    for name, n_before in (("ATTITUDE", 4), ("PITCHYAW", 0), ("MANUAL_CONTROL", 0)):
        for _ in range(30):
            values = [rng.choice(_EXTREMES) for _ in range(n_before + 4)]
            fields = (values[:4], *values[4:7]) if n_before else values
            flags, device = rng.choice([0, 1, 2, 16, 64, 2**32 - 1]), rng.randrange(256)
            laden.send(f"GIMBAL_MANAGER_SET_{name}", 1, _GIMBAL, flags, device, *fields)
            laden.step()
    came = laden.run(2.0)
    assert laden.server.faults.n_caught == 0, laden.server.faults.last
    assert named(came, "HEARTBEAT")
    gimbal = laden.payload.gimbal
    assert math.isfinite(gimbal.pitch_down_rad + gimbal.yaw_rad)
