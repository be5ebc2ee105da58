"""Sensors: noise as their data say, delay, range, and truth behind it all."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from scipy.spatial.transform import Rotation

from aeroscene.scene import OrientedBox, SceneObject
from aeroscene.scene.catalogue import category_id
from flightsim.environment.atmosphere import pressure_altitude_m, pressure_pa
from flightsim.environment.steel import disturb, steel_dipoles
from flightsim.plant.cfg import PlantCfg
from flightsim.plant.record import PLANT_DTYPE
from flightsim.plant.sensing import SENSORS, SensorReadings
from flightsim.sensors.airspeed import AIRSPEED, AirspeedCfg, sample_airspeed
from flightsim.sensors.barometer import BAROMETER, BarometerCfg, sample_barometer
from flightsim.sensors.drift import density_of, drift_terms
from flightsim.sensors.gnss import GNSS, RTK, STANDARD, follow_gnss, sample_gnss
from flightsim.sensors.imu import ADIS16448, IMU, PX4_IMU, sample_imu
from flightsim.sensors.magnetometer import MAGNETOMETER, MagnetometerCfg, sample_magnetometer
from flightsim.sensors.mocap import MOCAP
from flightsim.sensors.rangefinder import (
    RANGEFINDER,
    RangefinderCfg,
    aim_ray,
    sample_rangefinder,
)
from flightsim.sensors.sensor import NormalStream, SensorStart
from flightsim.sensors.vio import VIO
from tests.flightsim.handmade import empty_scene

HZ = 250
LEVEL = np.array([1.0, 0.0, 0.0, 0.0])
NO_NORMALS = np.zeros(IMU.n_normals)
STILL = np.zeros(4)
NO_STEEL = np.zeros((0, 5))


def rng():
    return np.random.default_rng(7)


def start(seed=7, **more):
    return SensorStart(tick_hz=HZ, rng=np.random.default_rng(seed), **more)


def pose(quat=LEVEL, position=(0.0, 0.0, 0.0)):
    return np.array([*position, *quat])


def perfect_imu(quat=LEVEL, velocity=(0.0, 0.0, 0.0)):
    cfg = dataclasses.replace(PX4_IMU, gyro_noise_density=0.0, accel_noise_density=0.0)
    return IMU.new(cfg, start(quat_wxyz=quat, velocity_enu_mps=velocity))[0]


def test_imu_at_rest_feels_gravity():
    r = perfect_imu()
    sample_imu(r, LEVEL, np.zeros(3), NO_NORMALS)
    np.testing.assert_allclose(r["accel_flu_mps2"], (0.0, 0.0, 9.81))
    np.testing.assert_allclose(r["gyro_flu_radps"], 0.0)


@given(
    hnp.arrays(float, 3, elements=st.floats(-3.0, 3.0)),
    hnp.arrays(float, 3, elements=st.floats(-20.0, 20.0)),
    hnp.arrays(float, 3, elements=st.floats(-3.0, 3.0)),
)
def test_imu_samples_integrate_to_the_true_motion(attitude, acceleration, rate):
    """Rate and specific force are the means that carry one state into the next."""
    start = Rotation.from_rotvec(attitude)
    r = perfect_imu(start.as_quat(scalar_first=True))
    end = start * Rotation.from_rotvec(rate / HZ)
    sample_imu(r, end.as_quat(scalar_first=True), acceleration / HZ, NO_NORMALS)
    np.testing.assert_allclose(r["gyro_flu_radps"], rate, atol=1e-6)
    middle = start * Rotation.from_rotvec(0.5 * rate / HZ)
    expected = middle.inv().apply(acceleration + np.array([0.0, 0.0, 9.81]))
    np.testing.assert_allclose(r["accel_flu_mps2"], expected, atol=1e-6)


@pytest.mark.parametrize("cfg", [ADIS16448, PX4_IMU])
def test_imu_noise_falls_with_the_square_root_of_averaging_time(cfg):
    """Allan deviation at short times is the density over sqrt(tau), and no bias shows yet."""
    cfg = dataclasses.replace(cfg, gyro_turn_on_sigma_radps=0.0, accel_turn_on_sigma_mps2=0.0)
    r = IMU.new(cfg, start())[0]
    normals = rng().standard_normal((40 * HZ, IMU.n_normals))
    gyro, accel = np.empty((len(normals), 3)), np.empty((len(normals), 3))
    for k, row in enumerate(normals):
        sample_imu(r, LEVEL, np.zeros(3), row)
        gyro[k], accel[k] = r["gyro_flu_radps"], r["accel_flu_mps2"]
    for samples in (1, 10, 50):
        tau = samples / HZ
        for data, density in ((gyro, cfg.gyro_noise_density), (accel, cfg.accel_noise_density)):
            means = data.reshape(-1, samples, 3).mean(axis=1)
            allan = math.sqrt(0.5 * np.mean(np.diff(means, axis=0) ** 2))
            assert allan == pytest.approx(density / math.sqrt(tau), rel=0.12)


def test_imu_biases_are_drawn_and_wander():
    records = [IMU.new(ADIS16448, start(k))[0] for k in range(300)]
    gyro = np.array([r["gyro_bias_flu_radps"] for r in records])
    accel = np.array([r["accel_bias_flu_mps2"] for r in records])
    assert gyro.std() == pytest.approx(0.0087, rel=0.1)
    assert accel.std() == pytest.approx(0.196, rel=0.1)
    r = records[0]
    before = r["accel_bias_flu_mps2"].copy()
    sample_imu(r, LEVEL, np.zeros(3), np.ones(IMU.n_normals))
    assert np.all(r["accel_bias_flu_mps2"] != before)


@given(st.floats(0.01, 5.0), st.floats(5.0, 500.0), st.floats(1e-3, 1.0))
def test_drift_keeps_its_stationary_deviation_at_any_rate(sigma, correlation_s, dt_s):
    decay, step = drift_terms(density_of(sigma, correlation_s), correlation_s, dt_s)
    assert math.sqrt(decay**2 * sigma**2 + step**2) == pytest.approx(sigma, rel=1e-9)


def gnss_track(cfg, seconds, velocity=(3.0, -2.0, 1.0), seed=7):
    """Errors of position and velocity of every fix along a straight flight."""
    r = GNSS.new(cfg, start(seed))[0]
    normals = np.random.default_rng(seed + 1)
    errors = []
    velocity = np.array(velocity)
    for tick in range(round(seconds * HZ)):
        follow_gnss(r, tick, velocity * tick / HZ, velocity)
        if tick % r["period_ticks"] == 0 and tick >= r["delay_ticks"]:
            sample_gnss(r, tick, normals.standard_normal(9))
            valid_s = (tick - r["delay_ticks"]) / HZ
            errors.append(
                (r["position_enu_m"] - velocity * valid_s, r["velocity_enu_mps"] - velocity)
            )
    return np.array(errors)


def test_a_fix_is_valid_for_a_time_before_its_delivery():
    silent = dataclasses.replace(
        RTK, drift_sigma_m=(0.0, 0.0), position_noise_m=(0.0, 0.0), velocity_noise_mps=(0.0, 0.0)
    )
    r = GNSS.new(silent, start())[0]
    assert r["delay_ticks"] == 30  # 0.12 s
    np.testing.assert_allclose(gnss_track(silent, 2.0), 0.0, atol=1e-12)


@pytest.mark.parametrize(("cfg", "hz"), [(RTK, 10), (STANDARD, 5)])
def test_fixes_come_at_their_rate(cfg, hz):
    assert len(gnss_track(cfg, 10.0)) == pytest.approx(10 * hz, abs=hz)


@pytest.mark.parametrize("cfg", [RTK, STANDARD])
def test_gnss_errors_have_their_grade(cfg):
    errors = np.concatenate([gnss_track(cfg, 6.0, seed=k) for k in range(60)])
    horizontal, vertical = cfg.drift_sigma_m
    spread = errors[:, 0].std(axis=0)
    expected = np.hypot(
        [horizontal, horizontal, vertical], [*cfg.position_noise_m[:1] * 2, cfg.position_noise_m[1]]
    )
    np.testing.assert_allclose(spread, expected, rtol=0.3)
    np.testing.assert_allclose(
        errors[:, 1].std(axis=0),
        [*cfg.velocity_noise_mps[:1] * 2, cfg.velocity_noise_mps[1]],
        rtol=0.1,
    )


def test_gnss_errors_wander_slowly():
    """Neighbouring fixes share their error; those minutes apart do not."""
    quiet = dataclasses.replace(RTK, position_noise_m=(0.0, 0.0))
    errors = gnss_track(quiet, 60.0)[:, 0]
    steps = np.diff(errors, axis=0).std()
    assert steps < 0.1 * quiet.drift_sigma_m[0]


@given(st.floats(-300.0, 8000.0))
def test_pressure_and_altitude_are_inverse(altitude):
    assert pressure_altitude_m(pressure_pa(altitude)) == pytest.approx(altitude, abs=1e-6)


def test_atmosphere_is_the_standard_one():
    # ISO 2533 tables
    assert pressure_pa(0.0) == pytest.approx(101325.0)
    assert pressure_pa(1000.0) == pytest.approx(89874.6, rel=1e-4)
    assert pressure_pa(5000.0) == pytest.approx(54019.9, rel=1e-4)


def test_barometer_noise_is_one_pascal_about_the_truth():
    r = BAROMETER.new(BarometerCfg(), start(altitude_m=488.0))[0]
    draws = rng().standard_normal((2000, 2))
    altitudes = np.empty(len(draws))
    pressures = np.empty(len(draws))
    for k, row in enumerate(draws):
        sample_barometer(r, k, 12.0, row)
        altitudes[k], pressures[k] = r["altitude_m"], r["pressure_pa"]
    assert pressures.std() == pytest.approx(1.0, rel=0.06)
    assert altitudes.mean() == pytest.approx(500.0, abs=0.01)
    assert r["temperature_degc"] == pytest.approx(15.0 - 3.25)


def test_barometer_drift_is_optional_and_bounded():
    cfg = BarometerCfg(noise_pa=0.0, drift_density_pa=0.5, drift_correlation_s=100.0)
    r = BAROMETER.new(cfg, start(altitude_m=0.0))[0]
    drifts = []
    for row in rng().standard_normal((50 * 1000, 2)):
        sample_barometer(r, 0, 0.0, row)
        drifts.append(r["pressure_pa"] - 101325.0)
    assert np.std(drifts) == pytest.approx(0.5 * math.sqrt(50.0), rel=0.5)


@given(hnp.arrays(float, 3, elements=st.floats(-3.0, 3.0)))
def test_magnetometer_sees_the_field_in_body_axes(vector):
    field = (0.8, 21.5, -42.8)
    attitude = Rotation.from_rotvec(vector)
    r = MAGNETOMETER.new(MagnetometerCfg(), start(field_enu_ut=field))[0]
    sample_magnetometer(
        r, 1, pose(attitude.as_quat(scalar_first=True)), STILL, NO_STEEL, np.zeros(6)
    )
    np.testing.assert_allclose(r["field_flu_ut"], attitude.inv().apply(field), atol=1e-9)


def test_magnetometer_noise_has_its_density():
    r = MAGNETOMETER.new(MagnetometerCfg(), start(field_enu_ut=(0.0, 20.0, 0.0)))[0]
    samples = []
    for row in rng().standard_normal((2000, 6)):
        sample_magnetometer(r, 1, pose(LEVEL), STILL, NO_STEEL, row)
        samples.append(r["field_flu_ut"].copy())
    assert np.std(samples, axis=0).mean() == pytest.approx(0.04 * math.sqrt(50.0), rel=0.05)


def test_the_current_of_the_motors_disturbs_the_magnetometer():
    """As strongly as the current, in one direction of the body that is drawn once."""
    quiet = MagnetometerCfg(noise_density=0.0, drift_density=0.0)
    earth = np.array((0.8, 21.5, -42.8))
    added = []
    for speed in (400.0, 800.0):
        r = MAGNETOMETER.new(quiet, start(field_enu_ut=earth, amperes_per_cubed_speed=1e-8))[0]
        sample_magnetometer(r, 1, pose(), np.full(4, speed), NO_STEEL, np.zeros(6))
        added.append(r["field_flu_ut"] - earth)
    np.testing.assert_allclose(added[1], 8.0 * added[0], rtol=1e-6)
    current_a = 4.0 * 800.0**3 * 1e-8
    assert np.linalg.norm(added[1]) == pytest.approx(0.03 * current_a)


def test_a_car_disturbs_the_field_as_a_shell_of_steel():
    """Above a shell in a vertical field the disturbance is 2 chi B (r / d)^3, upwards like B."""
    box = OrientedBox(p=(0.0, 0.0, 0.75), q=(1.0, 0.0, 0.0, 0.0), s=(4.4, 1.8, 1.5))
    car = SceneObject(
        id=1,
        scene_id="handmade",
        domain="outdoor",
        category_id=category_id("car"),
        parent_id=None,
        bbox=box,
    )
    dipoles = steel_dipoles(dataclasses.replace(empty_scene(), objects=(car,)))
    ((*centre, radius, chi),) = dipoles
    assert centre == [0.0, 0.0, 0.75]
    earth = np.array((0.0, 0.0, -43.0))
    for above in (1.0, 2.0, 3.0, 5.0):
        field = np.zeros(3)
        disturb(dipoles, np.array((0.0, 0.0, 0.75 + above)), earth, field)
        share = min(1.0, radius / above) ** 3
        np.testing.assert_allclose(field, (0.0, 0.0, -2.0 * chi * 43.0 * share))
        beside = np.zeros(3)
        disturb(dipoles, np.array((above, 0.0, 0.75)), earth, beside)
        np.testing.assert_allclose(beside, (0.0, 0.0, chi * 43.0 * share))
    assert 1.0 < 2.0 * chi * 43.0 * (radius / 2.0) ** 3 < 5.0
    field = np.zeros(3)
    disturb(dipoles, np.array((50.0, 0.0, 1.0)), earth, field)
    np.testing.assert_array_equal(field, 0.0)


def test_range_is_noisy_near_and_infinite_far():
    r = RANGEFINDER.new(RangefinderCfg(), start())[0]
    assert math.isnan(r["range_m"])
    readings = []
    for row in rng().standard_normal((1000, 1)):
        sample_rangefinder(r, 1, 10.0, row)
        readings.append(r["range_m"])
    assert np.std(readings) == pytest.approx(math.hypot(0.01, 0.03), rel=0.1)
    for nothing in (-1.0, 30.01):
        sample_rangefinder(r, 1, nothing, np.zeros(1))
        assert r["range_m"] == math.inf
    sample_rangefinder(r, 1, 0.001, np.full(1, -5.0))
    assert r["range_m"] == 0.0


@given(hnp.arrays(float, 3, elements=st.floats(-3.0, 3.0)))
def test_ray_looks_along_body_down(vector):
    attitude = Rotation.from_rotvec(vector)
    r = RANGEFINDER.new(RangefinderCfg(), start())[0]
    aim_ray(r, np.array([1.0, 2.0, 3.0]), attitude.as_quat(scalar_first=True))
    np.testing.assert_allclose(r["ray"][:3], (1.0, 2.0, 3.0))
    np.testing.assert_allclose(r["ray"][3:], attitude.apply([0.0, 0.0, -1.0]), atol=1e-9)


@given(
    hnp.arrays(float, 3, elements=st.floats(-3.0, 3.0)),
    hnp.arrays(float, 3, elements=st.floats(-15.0, 15.0)),
    hnp.arrays(float, 3, elements=st.floats(-15.0, 15.0)),
)
def test_a_pitot_tube_feels_the_air_that_comes_along_its_axis(vector, velocity, air):
    attitude = Rotation.from_rotvec(vector)
    perfect = AirspeedCfg(noise_pa=0.0, zero_sigma_pa=0.0, span_sigma=0.0)
    r = AIRSPEED.new(perfect, start(altitude_m=0.0))[0]
    quat = attitude.as_quat(scalar_first=True)
    sample_airspeed(r, 1, 0.0, quat, air, velocity, np.zeros(1))
    forward = attitude.inv().apply(velocity - air)[0]
    assert r["differential_pa"] == pytest.approx(
        0.5 * 1.225 * forward * abs(forward), rel=1e-4, abs=1e-6
    )
    assert r["indicated_mps"] == pytest.approx(forward, rel=1e-4, abs=1e-3)
    sample_airspeed(r, 1, 5000.0, quat, air, velocity, np.zeros(1))
    # ISO 2533: 0.7361 kg/m^3 at 5 km
    thin = math.sqrt(0.7361 / 1.225)
    assert r["indicated_mps"] == pytest.approx(thin * forward, rel=1e-3, abs=1e-3)
    assert r["temperature_degc"] == pytest.approx(-17.5)


def test_airspeed_errs_by_its_noise_and_by_what_was_drawn_once():
    tubes = [AIRSPEED.new(AirspeedCfg(), start(k))[0] for k in range(400)]
    assert np.std([r["zero_pa"] for r in tubes]) == pytest.approx(0.1, rel=0.1)
    assert np.std([r["span"] for r in tubes]) == pytest.approx(0.015, rel=0.1)
    readings = []
    for row in rng().standard_normal((1000, 1)):
        sample_airspeed(tubes[0], 1, 0.0, LEVEL, np.zeros(3), np.zeros(3), row)
        readings.append(tubes[0]["differential_pa"])
    assert np.std(readings) == pytest.approx(1.0, rel=0.1)


def test_streams_go_on_and_sensors_with_more_draws_leave_the_others_alone():
    short, long, other = np.zeros(8), np.zeros(45), np.zeros(3)
    stream = NormalStream(np.random.SeedSequence(1, spawn_key=(2,)), short)
    for key, block in ((2, long), (3, other)):
        NormalStream(np.random.SeedSequence(1, spawn_key=(key,)), block).draw()
    stream.draw()
    np.testing.assert_array_equal(short, long[:8])
    stream.draw()
    np.testing.assert_array_equal(short, long[8:16])
    assert not np.isin(other, long).any()


def test_no_two_sensors_share_a_stream_of_noise():
    streams = [(s.stream,) for s in SENSORS] + [s.start_streams for s in SENSORS]
    assert len(set(streams)) == 2 * len(SENSORS)
    assert not {9, 10, 11, 13, 14} & {s.stream for s in SENSORS}  # air, start, vibration, sky


@pytest.mark.parametrize("sensor", SENSORS, ids=lambda s: s.name)
def test_every_sensor_is_configured_built_and_read(sensor):
    """What a plant does with each: a sensor that is only half registered fails here."""
    r = sensor.new(sensor.cfg(PlantCfg(seed=0)), start())[0]
    assert r["tick"] == -1
    assert r["period_ticks"] * r["rate_hz"] == HZ
    assert sensor.name in PLANT_DTYPE.names
    reading = sensor.read(r, 4000)
    assert sensor.gauge is None or isinstance(sensor.gauge[1](reading), float)
    if sensor not in (VIO, MOCAP):  # poses that only the filter hears
        name = "range_m" if sensor is RANGEFINDER else sensor.name
        assert isinstance(getattr(SensorReadings, name), property)
