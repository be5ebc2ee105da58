"""The plant in flight: it holds, tracks, lands and estimates, and it is deterministic."""

import hashlib
import math
import subprocess
import sys

import mujoco
import numba
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from autonomy.types import IDLE, OFF, ControlLevel, Setpoint
from flightsim.environment.wind import WindCfg, WindError
from flightsim.plant import Fleet, NotAlignedError, Plant
from flightsim.plant.cfg import PlantCfg, PlantError
from flightsim.plant.compilation import example_arguments
from flightsim.plant.kernel import advance
from flightsim.sensors.failure import Failure
from flightsim.vehicles.catalogue import AIRFRAMES
from flightsim.world import build_world
from tests.flightsim.handmade import empty_scene

NAN = math.nan
YAW = 0.4


@pytest.fixture(scope="module")
def worlds():
    scene = empty_scene(yaw_rad=YAW)
    return {name: build_world(scene, AIRFRAMES[name]) for name in ("iris", "hummingbird")}


def position(x, y, z, **more):
    return Setpoint(level=ControlLevel.TRAJECTORY, position_enu_m=(x, y, z), yaw_rad=YAW, **more)


def velocity(x, y, z):
    return Setpoint(level=ControlLevel.TRAJECTORY, velocity_enu_mps=(x, y, z))


class Flight:
    """A plant and its whole history."""

    def __init__(self, world, **cfg):
        self.plant = Plant(world, PlantCfg(**{"seed": 5} | cfg))
        self.rows = []

    def fly(self, seconds, setpoint):
        """Follow a setpoint, or a function of the time since now, given at 50 Hz."""
        first = len(self.rows)
        for k in range(round(seconds * 50)):
            self.plant.apply(setpoint(0.02 * k) if callable(setpoint) else setpoint)
            self.plant.advance()
            self.rows.append(self.plant.history.copy())
        return np.concatenate(self.rows[first:])

    def take_off(self, height_m=3.0):
        self.fly(2.0, OFF)
        assert self.plant.estimator.is_position_valid
        self.fly(0.5, IDLE)
        x, y, z = self.plant.estimate.position_enu_m
        self.hover = (x, y, z + height_m)
        self.fly(5.0, position(*self.hover))
        return self

    @property
    def log(self):
        return np.concatenate(self.rows)


def attitude_error_deg(h):
    true = Rotation.from_quat(h["quat_true_wxyz"], scalar_first=True)
    estimated = Rotation.from_quat(h["quat_est_wxyz"], scalar_first=True)
    return np.degrees((true * estimated.inv()).magnitude())


def tilt_deg(h):
    q = h["quat_true_wxyz"]
    return np.degrees(np.arccos(np.clip(1.0 - 2.0 * (q[:, 1] ** 2 + q[:, 2] ** 2), -1.0, 1.0)))


def rms(x):
    return math.sqrt(np.mean(np.sum(np.atleast_2d(x.T).T ** 2, axis=-1)))


def figure_eight(centre):
    """Up to 6.8 m/s; begins and goes on smoothly."""
    cx, cy, cz = centre

    def at(t):
        w, ramp = 0.6, 4.0
        s, ds, dds = (
            (0.5 * w * t * t / ramp, w * t / ramp, w / ramp)
            if t < ramp
            else (w * (t - 0.5 * ramp), w, 0.0)
        )
        a, b = 8.0, 4.0
        x1, y1, x2, y2 = (
            a * math.cos(s),
            2 * b * math.cos(2 * s),
            -a * math.sin(s),
            -4 * b * math.sin(2 * s),
        )
        x3, y3 = -a * math.cos(s), -8 * b * math.cos(2 * s)
        return position(
            cx + a * math.sin(s),
            cy + b * math.sin(2 * s),
            cz,
            velocity_enu_mps=(x1 * ds, y1 * ds, 0.0),
            acceleration_enu_mps2=(x2 * ds**2 + x1 * dds, y2 * ds**2 + y1 * dds, 0.0),
            jerk_enu_mps3=(x3 * ds**3 + 3 * x2 * ds * dds, y3 * ds**3 + 3 * y2 * ds * dds, 0.0),
        )

    return at


@pytest.mark.parametrize("name", ["iris", "hummingbird"])
def test_a_minute_of_manoeuvres_keeps_estimate_and_track(worlds, name):
    flight = Flight(worlds[name]).take_off()
    start = len(flight.rows)
    eight = flight.fly(24.0, figure_eight(flight.hover))
    flight.fly(5.0, position(*flight.hover))
    flight.fly(4.0, velocity(0.0, 6.0, 0.5))
    flight.fly(8.0, position(*flight.hover))
    track = eight["position_est_enu_m"] - eight["reference_position_enu_m"]
    assert np.linalg.norm(eight["velocity_true_enu_mps"], axis=1).max() > 6.0
    assert rms(track) < 0.06
    h = flight.log[500:]  # from the alignment on
    assert rms(h["position_true_enu_m"] - h["position_est_enu_m"]) < 0.2
    assert rms(attitude_error_deg(h)) < 0.8
    assert not np.any(np.concatenate(flight.rows[start:])["is_touching"])


def test_biased_imu_stays_within_two_degrees(worlds):
    flight = Flight(worlds["iris"], imu="adis16448").take_off()
    flight.fly(15.0, figure_eight(flight.hover))
    h = flight.log[500:]
    assert np.abs(flight.plant.estimator.accel_bias_flu_mps2).max() > 0.01
    assert rms(attitude_error_deg(h)) < 2.0
    assert rms(h["position_true_enu_m"] - h["position_est_enu_m"]) < 0.2


def test_standard_gnss_is_metre_grade_and_flies(worlds):
    flight = Flight(worlds["iris"], gnss="standard").take_off()
    h = flight.fly(10.0, position(*flight.hover))
    error = rms(h["position_true_enu_m"] - h["position_est_enu_m"])
    assert 0.3 < error < 9.0
    assert rms(h["position_est_enu_m"] - h["reference_position_enu_m"]) < 0.3
    assert flight.plant.sensors.gnss.fix_type == 3


def test_wind_is_held_against(worlds):
    flight = Flight(worlds["iris"]).take_off()
    flight.plant.wind = WindCfg.towards((4.0, 3.0, 0.0))
    h = flight.fly(6.0, position(*flight.hover))
    off = np.linalg.norm(h["position_est_enu_m"] - flight.hover, axis=1)
    assert off.max() < 0.25
    assert off[750:].max() < 0.1
    assert tilt_deg(h)[-1] > 5.0  # it leans into it


def test_a_velocity_step_is_clean(worlds):
    flight = Flight(worlds["iris"]).take_off()
    h = flight.fly(2.5, velocity(2.0, 0.0, 0.0))
    v = h["velocity_true_enu_mps"]
    assert v[300:, 0].min() > 1.7
    assert v[:, 0].max() < 2.2
    assert np.abs(v[:, 1:]).max() < 0.2
    assert tilt_deg(h).max() < 30.0
    assert np.ptp(h["position_true_enu_m"][:, 2]) < 0.1


@pytest.mark.parametrize(("name", "descent_mps"), [("iris", 0.5), ("hummingbird", 0.3)])
def test_landing_neither_bounces_nor_slides_nor_tips(worlds, name, descent_mps):
    flight = Flight(worlds[name]).take_off(height_m=1.0)
    x, y, _ = flight.hover
    down = Setpoint(
        level=ControlLevel.TRAJECTORY,
        position_enu_m=(x, y, NAN),
        velocity_enu_mps=(NAN, NAN, -descent_mps),
        yaw_rad=YAW,
    )
    h = flight.fly(1.0 / descent_mps + 2.5, down)
    touchdown = np.argmax(h["is_touching"])
    after = h[touchdown:]
    assert len(after) > 250
    assert after["position_true_enu_m"][:, 2].max() < after["position_true_enu_m"][0, 2] + 0.005
    assert tilt_deg(after).max() < 4.0
    # what presses the reference down unloads the rotors: a landing detector can see it
    assert flight.plant.collective_thrust_fraction < 0.7 * hover_fraction(name)
    flight.fly(0.5, IDLE)
    rest = flight.fly(2.0, OFF)  # in which the rotors coast to a halt
    assert np.linalg.norm(np.ptp(rest["position_true_enu_m"], axis=0)) < 0.002
    assert tilt_deg(rest).max() < 1.0
    np.testing.assert_allclose(flight.plant.rotor_speeds_radps, 0.0, atol=1e-6)


def hover_fraction(name):
    return AIRFRAMES[name].quadrotor.hover_thrust_fraction


@settings(max_examples=4)
@given(st.integers(0, 2**32 - 1))
def test_the_same_seed_gives_the_same_bits(worlds, seed):
    logs = []
    for _ in range(2):
        flight = Flight(worlds["iris"], seed=seed)
        flight.fly(1.3, OFF)
        flight.fly(0.7, position(1.0, 1.0, 2.0))
        logs.append(flight.log.tobytes())
    assert logs[0] == logs[1]
    other = Flight(worlds["iris"], seed=seed + 1)
    other.fly(1.3, OFF)
    assert other.log["gyro_flu_radps"].tobytes() != flight.log["gyro_flu_radps"][:325].tobytes()


_SCRIPT = """
import sys
sys.path[:0] = sys.argv[1:]
from test_plant import history_digest
print(history_digest())
"""


def history_digest():
    flight = Flight(build_world(empty_scene(yaw_rad=YAW), AIRFRAMES["iris"]), seed=11)
    flight.fly(1.5, OFF)
    flight.fly(1.5, position(1.0, 1.0, 2.0))
    return hashlib.sha256(flight.log.tobytes()).hexdigest()


def test_another_process_gives_the_same_bits(request):
    folders = [str(request.path.parent), str(request.config.rootpath)]
    result = subprocess.run(
        [sys.executable, "-c", _SCRIPT, *folders], capture_output=True, text=True, check=True
    )
    assert result.stdout.strip() == history_digest()


def test_ahead_of_time_compilation_is_for_the_types_of_one_plant_and_of_many(worlds):
    cfgs = [PlantCfg(seed=0)] * 2
    Plant(worlds["iris"], cfgs[0]).advance()
    with Fleet([worlds["iris"]] * 2, cfgs) as fleet:
        fleet.advance()
        fleet.advance_one(1)
    expected = tuple(numba.typeof(argument) for argument in example_arguments())
    assert list(advance.overloads) == [expected]


def test_before_the_first_advance_everything_is_readable(worlds):
    plant = Plant(worlds["iris"], PlantCfg(seed=0))
    assert plant.time_us == 0
    assert plant.truth.position_enu_m == tuple(plant.data.qpos[:3])
    assert plant.estimate.quat_wxyz == (1.0, 0.0, 0.0, 0.0)
    assert not plant.estimator.is_attitude_valid
    assert plant.estimator.sigma_horizontal_m == math.inf
    assert plant.sensors.gnss.fix_type == 1
    assert math.isnan(plant.sensors.range_m)
    assert math.isnan(plant.terrain_height_est_m)


def test_time_rates_and_stamps(worlds):
    flight = Flight(worlds["iris"])
    h = flight.fly(2.0, OFF)
    plant = flight.plant
    assert plant.time_us == 2_000_000
    np.testing.assert_array_equal(h["time_us"], np.arange(1, 501) * 4000)
    s = plant.sensors
    assert s.imu.time_us == 2_000_000
    assert s.baro.time_us == 2_000_000
    assert s.gnss.time_us == 2_000_000 - 120_000
    assert s.gnss.fix_type == 6
    assert s.baro.altitude_m == pytest.approx(488.0 + plant.truth.position_enu_m[2], abs=0.6)
    assert s.range_m == pytest.approx(plant.truth.position_enu_m[2], abs=0.06)
    assert plant.terrain_height_est_m == pytest.approx(0.0, abs=0.4)


def test_contact_is_counted_on_the_ground_and_not_in_the_air(worlds):
    flight = Flight(worlds["iris"])
    flight.fly(2.0, OFF)
    assert flight.plant.contact_ticks == 5
    assert flight.plant.total_contact_ticks == 500
    flight.take_off()
    before = flight.plant.total_contact_ticks
    flight.fly(1.0, position(*flight.hover))
    assert flight.plant.contact_ticks == 0
    assert flight.plant.total_contact_ticks == before


def test_mujoco_times_its_stages_for_others_but_not_for_the_plant(worlds):
    world = worlds["iris"]
    plant = Plant(world, PlantCfg(seed=1))
    plant.advance()
    assert plant.data.timer[mujoco.mjtTimer.mjTIMER_STEP].duration == 0.0
    data = world.new_data()
    mujoco.mj_step(world.model, data)
    assert data.timer[mujoco.mjtTimer.mjTIMER_STEP].duration > 0.0


def test_setpoints_that_are_not_numbers_are_refused(worlds, caplog):
    flight = Flight(worlds["iris"]).take_off()
    for bad in (
        Setpoint(level=ControlLevel.ATTITUDE, thrust=NAN),
        Setpoint(level=ControlLevel.ATTITUDE, quat_wxyz=(0.0, 0.0, 0.0, 0.0), thrust=0.5),
        Setpoint(level=ControlLevel.RATE, angular_rate_flu_radps=(NAN, 0.0, 0.0), thrust=0.5),
    ):
        h = flight.fly(0.5, bad)
        assert tilt_deg(h).max() < 5.0
    assert flight.plant.n_refused_setpoints == 75
    assert len(caplog.records) == 1
    h = flight.fly(1.0, Setpoint(level=ControlLevel.TRAJECTORY))  # all NaN: brake
    assert np.all(np.isfinite(h["rotor_command_radps"]))
    assert np.abs(h["velocity_true_enu_mps"]).max() < 0.3


def test_attitude_and_rate_levels_are_flown(worlds):
    flight = Flight(worlds["iris"]).take_off(height_m=8.0)
    quat = tuple((Rotation.from_euler("z", YAW) * Rotation.from_euler("y", 0.3)).as_quat(
        scalar_first=True
    ))  # fmt: skip
    h = flight.fly(0.6, Setpoint(level=ControlLevel.ATTITUDE, quat_wxyz=quat, thrust=0.55))
    assert tilt_deg(h)[-1] == pytest.approx(math.degrees(0.3), abs=1.5)
    h = flight.fly(
        0.4,
        Setpoint(level=ControlLevel.RATE, angular_rate_flu_radps=(0.0, -1.0, 0.0), thrust=0.55),
    )
    assert h["angular_rate_true_flu_radps"][-1, 1] == pytest.approx(-1.0, abs=0.1)
    h = flight.fly(4.0, velocity(0.0, 0.0, 0.0))
    assert tilt_deg(h)[-1] < 3.0
    assert not h["is_touching"].any()


def test_lost_satellites_leave_a_valid_then_an_invalid_position(worlds):
    flight = Flight(worlds["iris"]).take_off(height_m=6.0)
    flight.plant.failures.fail_sensor("gnss", Failure.OFF)
    flight.fly(1.0, velocity(0.0, 0.0, 0.0))
    assert flight.plant.estimator.is_position_valid
    assert flight.plant.estimator.gnss_age_s > 0.9
    assert flight.plant.sensors.gnss.fix_type == 1
    assert flight.plant.sensors.gnss.n_satellites == 0
    sigma = flight.plant.estimator.sigma_horizontal_m
    flight.fly(10.0, velocity(0.0, 0.0, 0.0))
    assert flight.plant.estimator.sigma_horizontal_m > 3.0 * sigma
    flight.plant.failures.fail_sensor("gnss", Failure.NONE)
    flight.fly(4.0, velocity(0.0, 0.0, 0.0))
    error = np.subtract(flight.plant.truth.position_enu_m, flight.plant.estimate.position_enu_m)
    assert np.linalg.norm(error) < 0.4


def test_a_reading_is_made_once_until_the_sensor_measures_again_or_is_switched(worlds):
    plant = Flight(worlds["iris"]).plant
    plant.align()
    first = plant.sensors.imu
    assert plant.sensors.imu is first
    plant.advance()
    assert plant.sensors.imu.time_us == plant.time_us
    assert plant.sensors.imu != first
    assert plant.sensors.gnss.fix_type > 1
    plant.failures.fail_sensor("gnss", Failure.OFF)
    assert plant.sensors.gnss.fix_type == 1


def test_a_failed_rotor_brings_the_vehicle_down_and_ends_nothing(worlds):
    flight = Flight(worlds["iris"]).take_off()
    flight.plant.failures.weaken_rotor(0, 0.0)
    h = flight.fly(3.0, position(*flight.hover))
    assert h["is_touching"].any()
    assert np.all(np.isfinite(h["rotor_command_radps"]))
    assert np.all(np.isfinite(h["position_est_enu_m"]))


def test_an_empty_battery_stops_the_rotors(worlds):
    flight = Flight(worlds["iris"]).take_off()
    flight.plant.battery._used_c = flight.plant.battery._initial_c
    flight.fly(2.0, position(*flight.hover))
    np.testing.assert_allclose(flight.plant.rotor_speeds_radps, 0.0, atol=1e-3)


@pytest.mark.parametrize(
    ("cfg", "message"),
    [
        ({"physics_hz": 1000}, "steps at 500 Hz"),
        ({"control_hz": 130}, "multiple of 50"),
        ({"control_hz": 200}, "multiple of control_hz"),
    ],
)
def test_rates_that_do_not_fit_are_named(worlds, cfg, message):
    with pytest.raises(PlantError, match=message):
        Plant(worlds["iris"], PlantCfg(seed=0, **cfg))


def test_a_world_without_vehicle_is_no_plant():
    world = build_world(empty_scene())
    with pytest.raises(PlantError, match="vehicle"):
        Plant(world, PlantCfg(seed=0))


def test_impossible_wind_and_rotor_are_refused(worlds):
    plant = Plant(worlds["iris"], PlantCfg(seed=0))
    with pytest.raises(WindError):
        plant.wind = WindCfg.towards((100.0, 0.0, 0.0))
    with pytest.raises(PlantError, match="0 to 3"):
        plant.failures.weaken_rotor(4, 0.5)


def test_physics_at_a_kilohertz_flies_too():
    world = build_world(empty_scene(yaw_rad=YAW), AIRFRAMES["hummingbird"], physics_hz=1000)
    flight = Flight(world, physics_hz=1000).take_off(height_m=1.5)
    h = flight.fly(2.0, position(*flight.hover))
    assert rms(h["position_est_enu_m"] - flight.hover) < 0.1


@pytest.mark.parametrize(
    "level", [ControlLevel.TRAJECTORY, ControlLevel.ATTITUDE, ControlLevel.RATE]
)
def test_setpoints_before_the_alignment_are_refused_by_name(worlds, level):
    plant = Plant(worlds["iris"], PlantCfg(seed=0))
    setpoint = Setpoint(level=level, position_enu_m=(0.0, 0.0, 3.0), thrust=0.5)
    plant.apply(IDLE)
    with pytest.raises(NotAlignedError, match=rf"{level.name} after 0\.00 s.*align\(\)"):
        plant.apply(setpoint)
    plant.align()
    assert 0 < plant.time_us <= 2_000_000
    plant.apply(setpoint)
    Plant(worlds["iris"], PlantCfg(seed=0, state="truth")).apply(setpoint)


def test_an_alignment_that_cannot_come_ends_with_what_is_missing(worlds):
    plant = Plant(worlds["iris"], PlantCfg(seed=0))
    plant.failures.fail_sensor("gnss", Failure.OFF)
    with pytest.raises(NotAlignedError, match=r"after 3 s.*satellites"):
        plant.align(timeout_s=3.0)
    with pytest.raises(PlantError, match="'radar': valid are gnss, vio"):
        plant.failures.fail_sensor("radar", Failure.OFF)
