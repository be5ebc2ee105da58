"""What the kernel streams is what Python and pymavlink would say, byte for byte."""

import math
import random
import struct

import pytest

from autonomy.types import ControlLevel
from flightsim.frames import (
    Geodetic,
    euler_rpy_rad,
    swap_enu_ned,
    swap_flu_frd,
    swap_quat_enu_flu_ned_frd,
    swap_yaw_enu_ned,
)
from flightsim.mavlink.channel import DATAGRAM_BYTES, Channel
from flightsim.mavlink.dialect import LAYOUTS
from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.personalities import ARDUPILOT, PX4
from flightsim.mavlink.streaming import MOST_PARTS, TOLD, Streamer, Told
from flightsim.mavlink.streams import StreamTable
from tests.flightsim.mavlink.conftest import Flight
from tests.flightsim.mavlink.wire import Wire


def _int16(value):
    return max(-32768, min(32767, round(value)))


class Said:
    """What each compiled message ought to say of a flight, in plain Python."""

    def __init__(self, flight):
        self.flight = flight
        self.estimate, self.truth = flight.plant.estimate, flight.plant.truth
        self.setpoint, self.sensors = flight.autopilot.setpoint, flight.plant.sensors
        self.boot = {"time_boot_ms": flight.plant.time_us // 1000}
        self.now = {"time_usec": flight.plant.time_us}
        self.origin_enu_m = flight.server._view.origin_enu_m
        self.ned = self._ned(self.estimate.position_enu_m)
        self.velocity = swap_enu_ned(self.estimate.velocity_enu_mps)
        self.quat = swap_quat_enu_flu_ned_frd(self.estimate.quat_wxyz)
        self.rpy = euler_rpy_rad(self.quat)
        rates = swap_flu_frd(self.estimate.angular_rate_flu_radps)
        self.rates = dict(zip(("rollspeed", "pitchspeed", "yawspeed"), rates, strict=True))
        self.place = flight.frame.geodetic_from_enu(self.estimate.position_enu_m)
        home = flight.autopilot.home
        self.height_m = self.place.altitude_m - (
            home.geodetic.altitude_m
            if home
            else flight.frame.origin.altitude_m + self.origin_enu_m[2]
        )
        self.heading_deg = math.degrees(self.rpy[2]) % 360.0

    def _ned(self, position_enu_m):
        x, y, z = position_enu_m
        x0, y0, z0 = self.origin_enu_m
        return (y - y0, x - x0, z0 - z)

    def of(self, name):
        """Its fields; None if there is nothing to tell."""
        if not self.flight.plant.is_aligned and name not in _BEFORE_ALIGNMENT:
            return None
        return getattr(self, name.lower())()

    def attitude(self):
        return {**self.boot, **_named("roll pitch yaw", self.rpy), **self.rates}

    def attitude_quaternion(self):
        return {**self.boot, **_named("q1 q2 q3 q4", self.quat), **self.rates}

    def attitude_target(self):
        is_given = self.setpoint.level is ControlLevel.ATTITUDE
        quat = swap_quat_enu_flu_ned_frd(self.setpoint.quat_wxyz) if is_given else self.quat
        rates = swap_flu_frd(self.setpoint.angular_rate_flu_radps)
        names = "body_roll_rate body_pitch_rate body_yaw_rate"
        thrust = self.flight.plant.collective_thrust_fraction
        return {**self.boot, "q": quat, **_named(names, rates), "thrust": thrust}

    def local_position_ned(self):
        return {**self.boot, **_named("x y z vx vy vz", (*self.ned, *self.velocity))}

    def global_position_int(self):
        return {
            **self.boot,
            "lat": round(self.place.latitude_deg * 1e7),
            "lon": round(self.place.longitude_deg * 1e7),
            "alt": round(self.place.altitude_m * 1e3),
            "relative_alt": round(self.height_m * 1e3),
            **_named("vx vy vz", [_int16(100.0 * v) for v in self.velocity]),
            "hdg": round(self.heading_deg * 100.0) % 36000,
        }

    def odometry(self):
        w, x, y, z = self.quat
        a, b, c = self.velocity
        tx, ty, tz = 2 * (b * z - c * y), 2 * (c * x - a * z), 2 * (a * y - b * x)
        body = (
            a + w * tx + ty * z - tz * y,
            b + w * ty + tz * x - tx * z,
            c + w * tz + tx * y - ty * x,
        )
        unknown = (math.nan, *(0.0,) * 20)
        return {
            **self.now,
            **_named("x y z vx vy vz", (*self.ned, *body)),
            "q": self.quat,
            **self.rates,
            **dict.fromkeys(("pose_covariance", "velocity_covariance"), unknown),
            **_named("frame_id child_frame_id estimator_type quality", (1, 12, 8, 100)),
        }

    def vfr_hud(self):
        return {
            "airspeed": max(0.0, self.sensors.airspeed.indicated_mps),
            "groundspeed": math.hypot(*self.velocity[:2]),
            "alt": self.place.altitude_m,
            "climb": -self.velocity[2],
            "heading": round(self.heading_deg) % 360,
            "throttle": round(100.0 * self.flight.plant.collective_thrust_fraction),
        }

    def altitude(self):
        altitude_m = self.place.altitude_m
        terrain_m = self.flight.plant.terrain_height_est_m
        clearance_m = self.estimate.position_enu_m[2] - terrain_m
        return {
            **self.now,
            **dict.fromkeys(("altitude_monotonic", "altitude_amsl"), altitude_m),
            "altitude_local": -self.ned[2],
            "altitude_relative": self.height_m,
            "altitude_terrain": altitude_m - clearance_m,
            "bottom_clearance": clearance_m,
        }

    def position_target_local_ned(self):
        s = self.setpoint
        if s.level is not ControlLevel.TRAJECTORY:
            return None
        vectors = (
            *self._ned(s.position_enu_m),
            *swap_enu_ned(s.velocity_enu_mps),
            *swap_enu_ned(s.acceleration_enu_mps2),
        )
        bits = sum(math.isnan(v) << axis for axis, v in enumerate(vectors))
        has_yaw = not math.isnan(s.yaw_rad)
        return {
            **self.boot,
            **_named("x y z vx vy vz afx afy afz", vectors),
            "yaw": swap_yaw_enu_ned(s.yaw_rad) if has_yaw else 0.0,
            "yaw_rate": -s.yaw_rate_radps,
            "type_mask": bits | (0 if has_yaw else 1024),
            "coordinate_frame": 1,
        }

    def position_target_global_int(self):
        target = self.flight.autopilot.target_enu_m
        if target is None:
            return None
        place, yaw = self.flight.frame.geodetic_from_enu(target), self.setpoint.yaw_rad
        has_yaw = not math.isnan(yaw)
        return {
            **self.boot,
            "lat_int": round(place.latitude_deg * 1e7),
            "lon_int": round(place.longitude_deg * 1e7),
            "alt": place.altitude_m,
            "yaw": swap_yaw_enu_ned(yaw) if has_yaw else 0.0,
            "type_mask": 7 << 3 | 7 << 6 | 2048 | (0 if has_yaw else 1024),
            "coordinate_frame": 5,
        }

    def nav_controller_output(self):
        target = self.flight.autopilot.target_enu_m
        if target is None:
            return None
        ahead = self._ned(target)
        north, east = ahead[0] - self.ned[0], ahead[1] - self.ned[1]
        bearing = round(math.degrees(math.atan2(east, north)))
        return {
            "nav_roll": math.degrees(self.rpy[0]),
            "nav_pitch": math.degrees(self.rpy[1]),
            "alt_error": self.ned[2] - ahead[2],
            **dict.fromkeys(("nav_bearing", "target_bearing"), bearing),
            "wp_dist": round(math.hypot(north, east)),
        }

    def hil_state_quaternion(self):
        state, plant = self.truth, self.flight.plant
        place = self.flight.frame.geodetic_from_enu(state.position_enu_m)
        rates = swap_flu_frd(state.angular_rate_flu_radps)
        velocity = [_int16(100.0 * v) for v in swap_enu_ned(state.velocity_enu_mps)]
        air = _int16(100.0 * math.dist(state.velocity_enu_mps, plant.air_velocity_true_enu_mps))
        accel = [1000.0 * a / 9.80665 for a in swap_flu_frd(self.sensors.imu.accel_flu_mps2)]
        return {
            **self.now,
            "attitude_quaternion": swap_quat_enu_flu_ned_frd(state.quat_wxyz),
            **_named("rollspeed pitchspeed yawspeed", rates),
            "lat": round(place.latitude_deg * 1e7),
            "lon": round(place.longitude_deg * 1e7),
            "alt": round(place.altitude_m * 1e3),
            **_named("vx vy vz", velocity),
            **dict.fromkeys(("ind_airspeed", "true_airspeed"), air),
            **_named("xacc yacc zacc", [_int16(a) for a in accel]),
        }

    def highres_imu(self):
        imu, baro = self.sensors.imu, self.sensors.baro
        field = [0.01 * b for b in swap_flu_frd(self.sensors.mag.field_flu_ut)]
        names = "xacc yacc zacc xgyro ygyro zgyro xmag ymag zmag"
        motion = (*swap_flu_frd(imu.accel_flu_mps2), *swap_flu_frd(imu.gyro_flu_radps))
        return {
            **self.now,
            **_named(names, (*motion, *field)),
            "abs_pressure": 0.01 * baro.pressure_pa,
            "diff_pressure": 0.01 * self.sensors.airspeed.differential_pa,
            "pressure_alt": baro.altitude_m,
            "temperature": baro.temperature_degc,
            "fields_updated": 0x1FFF,
        }

    def distance_sensor(self):
        range_m = self.sensors.range_m
        is_valid = math.isfinite(range_m)
        return {
            **self.boot,
            "min_distance": 10,
            "max_distance": 3000,
            "current_distance": min(3001, round(100.0 * range_m)) if is_valid else 3001,
            "orientation": mav.MAV_SENSOR_ROTATION_PITCH_270,
            "covariance": 255,
            "signal_quality": 100 if is_valid else 1,
        }

    def servo_output_raw(self):
        plant = self.flight.plant
        airframe, speeds = plant.world.airframe, plant.rotor_speed_commands_radps
        most = max(rotor.max_speed_radps for rotor in airframe.quadrotor.rotors)
        pulses = {
            f"servo{number}_raw": 1000 + round(1000 * (speeds[rotor] / most))
            if self.flight.autopilot.is_armed or speeds[rotor] > 0.0
            else 900
            for number, rotor in enumerate(airframe.motors, start=1)
        }
        return {"time_usec": plant.time_us & 0xFFFFFFFF, **pulses}


_BEFORE_ALIGNMENT = frozenset(
    {"HIL_STATE_QUATERNION", "HIGHRES_IMU", "DISTANCE_SENSOR", "SERVO_OUTPUT_RAW"}
)


def _named(names, values):
    return dict(zip(names.split(), values, strict=True))


def _is_as_pymavlink_packs(name, frame):
    """Whether pymavlink, given what it reads in a frame, builds the same frame."""
    decoded = mav.MAVLink(None).decode(bytearray(frame))
    encoder = mav.MAVLink(None, decoded.get_srcSystem(), decoded.get_srcComponent())
    encoder.seq = decoded.get_seq()
    assert decoded.get_type() == name
    return bytes(decoded.pack(encoder)) == frame


def _split(data):
    """Frames of MAVLink 2, one after the other."""
    while data:
        end = 12 + data[1]
        yield data[:end]
        data = data[end:]


def _frames_of(flight):
    """Frames of a tick by the name of their message."""
    flight.simulator.step()
    frames = list(_split(flight.link.client.recv()))
    numbers = [frame[4] for frame in frames]
    assert numbers == [(numbers[0] + k) & 0xFF for k in range(len(numbers))]
    return {_name_of(frame): frame for frame in frames}


def _name_of(frame):
    return mav.mavlink_map[int.from_bytes(frame[7:10], "little")].msgname


def _payload(name, frame):
    return frame[10:-2].ljust(LAYOUTS[name].size, b"\0")


def _stream_everything(flight):
    for name in TOLD:
        wanted = (LAYOUTS[name].message_id, 20_000)
        assert flight.command(mav.MAV_CMD_SET_MESSAGE_INTERVAL, *wanted) == 0


def test_every_compiled_message_says_what_python_would(flight):
    _stream_everything(flight)
    said = set()

    def compare():
        frames = _frames_of(flight)
        expected = Said(flight)
        for name in TOLD:
            fields = expected.of(name)
            assert (name in frames) == (fields is not None), name
            if fields is not None:
                assert _payload(name, frames[name]) == LAYOUTS[name].encode(**fields), name
                said.add(name)

    for _ in range(80):  # The estimator aligns meanwhile.
        compare()
    flight.take_off()
    flight.command_int(
        mav.MAV_CMD_DO_REPOSITION, 6, -1, 1, 0, 0.8, round(47.4003e7), round(8.4997e7), 13.0
    )
    for _ in range(150):
        compare()
    assert said == set(TOLD)


@pytest.mark.parametrize("personality", [PX4, ARDUPILOT], ids=lambda p: p.name)
def test_every_streamed_frame_is_one_of_pymavlinks_own(field, personality):
    flight = Flight(field, personality)
    flight.send("HEARTBEAT", 6, 8, 0, 0, 4, 3)
    seen = set()
    for _ in range(600):
        for name, frame in _frames_of(flight).items():
            assert _is_as_pymavlink_packs(name, frame), name
            seen.add(name)
    flight.close()
    assert len(seen) > 25


def test_a_diverged_estimate_is_not_told(flight):
    _stream_everything(flight)
    flight.become_ready()
    expected = set(TOLD) - {"POSITION_TARGET_LOCAL_NED"}
    targets = {"POSITION_TARGET_GLOBAL_INT", "NAV_CONTROLLER_OUTPUT"}
    assert set(_frames_of(flight)) >= expected - targets
    told = Told(flight.server._view)
    streamer = Streamer([LAYOUTS[name] for name in TOLD], told)
    place, attitude = TOLD.index("LOCAL_POSITION_NED"), TOLD.index("ATTITUDE")
    whole = TOLD.index("GLOBAL_POSITION_INT")
    position = flight.plant.filter["position_enu_m"]
    for wrong, is_told in ((1e30, True), (1e39, False), (math.inf, True), (math.nan, True)):
        position[0] = wrong
        assert bool(streamer.fill(place, flight.plant.time_us)) is is_told
        assert not streamer.fill(whole, flight.plant.time_us)
        assert streamer.fill(attitude, flight.plant.time_us)


class _Told:
    """Streams what Python packs, of any message, to a partner that gets it in each tick."""

    def __init__(self, names, seed, way=1):
        self.layouts = [LAYOUTS[name] for name in names]
        self.streamer = Streamer(self.layouts, None)
        self.table = StreamTable("normal", [layout.message_id for layout in self.layouts])
        for layout in self.layouts:
            self.table.set_interval(layout.message_id, 20_000)
        ids = (7, 9)
        self.streamed = self.streamer.new_partner(self.table.partner, self.table.is_due, *ids)
        self.streamer.serve([self.streamed])
        self.rng, self.way, self.now_us = random.Random(seed), way, 0
        self.packed = {}

    def tick(self, sequence):
        self.now_us += 20_000
        self.packed.clear()
        self.streamed.serve(self.way, sequence)
        self.streamer.stream(self.now_us, self._pack)

    def _pack(self, index):
        layout = self.layouts[index]
        parts = tuple(
            self.rng.randbytes(self.rng.randint(0, layout.size)).ljust(layout.size, b"\0")
            for _ in range(self.rng.randint(0, MOST_PARTS))
        )
        assert index not in self.packed, "packed twice in a tick"
        self.packed[index] = parts
        return parts


def test_frames_of_a_tick_are_those_of_its_messages():
    told = _Told(list(LAYOUTS), 0)
    for sequence in (0, 200, 255):
        told.tick(sequence)
        ordered = [(i, part) for i, parts in sorted(told.packed.items()) for part in parts]
        one_by_one = [
            told.layouts[index].frame_v2(payload, (sequence + number) & 0xFF, 7, 9)
            for number, (index, payload) in enumerate(ordered)
        ]
        assert len(told.packed) == len(LAYOUTS)
        assert told.streamed.n_frames == len(one_by_one)
        assert told.streamed.frames == b"".join(one_by_one)


def test_a_partner_that_waits_gets_each_message_once_when_it_is_served_again():
    told = _Told(["ATTITUDE", "PING"], 0, way=0)
    for _ in range(5):
        told.tick(0)
        assert told.streamed.n_frames == 0
        assert not told.packed
    told.way = 1
    told.tick(0)
    assert sorted(told.packed) == [0, 1]
    assert told.streamed.n_frames == sum(map(len, told.packed.values()))


def test_who_is_sent_to_otherwise_has_what_is_due_and_no_frames():
    told = _Told(["ATTITUDE", "PING"], 0, way=2)
    told.tick(0)
    assert told.streamed.n_frames == 0
    assert told.streamed.take_due() == [0, 1]
    assert [tuple(told.streamer.payloads(index)) for index in (0, 1)] == [*told.packed.values()]
    assert told.streamed.take_due() == []


def test_a_tick_that_is_longer_than_a_datagram_is_divided_between_frames():
    datagrams = []
    channel = Channel(
        "test",
        lambda frames: datagrams.append(b"".join(frames)),
        profile="normal",
        clock=lambda: 0.0,
        is_datagram=True,
    )
    told = _Told(list(LAYOUTS), 1)
    told.tick(channel.sequence)
    channel.stream(told.streamed.frames, told.streamed.n_frames)
    channel.flush()
    assert max(map(len, datagrams)) <= DATAGRAM_BYTES
    assert min(map(len, datagrams[:-1])) > DATAGRAM_BYTES / 2
    assert b"".join(datagrams) == told.streamed.frames
    frames = [frame for data in datagrams for frame in _split(data)]
    assert len(frames) == told.streamed.n_frames > 300
    assert channel.sequence == len(frames) & 0xFF
    assert len(Wire().decode(b"".join(datagrams))) == len(frames)


def test_what_is_asked_for_in_a_tick_does_not_make_its_stream_old(flight):
    flight.become_ready()
    flight.autopilot.set_home(None)
    told = Told(flight.server._view)
    streamer = Streamer([LAYOUTS["ALTITUDE"]], told)
    (before,) = streamer.fill(0, flight.plant.time_us)
    place = flight.autopilot.home.geodetic
    higher = Geodetic(place.latitude_deg, place.longitude_deg, place.altitude_m + 5.0)
    flight.autopilot.set_home(higher)
    table = StreamTable("normal", [LAYOUTS["ALTITUDE"].message_id])
    table.set_interval(LAYOUTS["ALTITUDE"].message_id, 20_000)
    streamed = streamer.new_partner(table.partner, table.is_due, 1, 1)
    streamed.serve(1, 0)
    streamer.serve([streamed])
    streamer.stream(flight.plant.time_us, lambda _: ())
    after = _payload("ALTITUDE", streamed.frames)
    then, now = (
        dict(zip(LAYOUTS["ALTITUDE"].fields, struct.unpack("<Q6f", payload), strict=True))
        for payload in (before, after)
    )
    assert now["altitude_relative"] == pytest.approx(then["altitude_relative"] - 5.0, abs=1e-3)
