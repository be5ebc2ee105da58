"""Configuration of the plant, and its errors."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Literal

from autonomy.control import ControllerCfg
from autonomy.estimation import EstimatorCfg
from autonomy.model.quadrotor import GRAVITY_MPS2
from flightsim.environment.effects import ALL_EFFECTS, Effects
from flightsim.environment.magnetic_field import FIELD_ENU_UT
from flightsim.environment.wind import CALM, WindCfg
from flightsim.plant.sensing import SENSORS
from flightsim.sensors.airspeed import AirspeedCfg
from flightsim.sensors.barometer import BarometerCfg
from flightsim.sensors.gnss import GRADES
from flightsim.sensors.imu import IMUS
from flightsim.sensors.magnetometer import MagnetometerCfg
from flightsim.sensors.mocap import MocapCfg
from flightsim.sensors.optical_flow import OPTICAL_FLOW, OpticalFlowCfg
from flightsim.sensors.rangefinder import RangefinderCfg
from flightsim.sensors.vio import VioCfg

ADVANCE_HZ = 50
"""Calls of `Plant.advance` a simulated second, which is the rate of the autopilot and MAVLink."""

_PRESSURE_GRADIENT_PAPM = 11.6
"""Pressure gradient of the standard atmosphere near 400 m above the sea."""

_USUAL_CURRENT_A = 15.0
"""Current of the motors in hover."""
_DISTURBANCE_LASTS_S = 6.0
"""Correlation time of the heading's disturbance by motors, and by steel that the vehicle flies
past."""

# Settings of `aiding` with which each of these sensors is switched on.
_AIDED_BY = {"gnss": ("gnss", "auto"), "vio": ("vio", "auto"), "mocap": ("mocap",)}


class PlantError(ValueError):
    """A plant cannot be built or switched as requested; the message names what would be valid."""


class NotAlignedError(RuntimeError):
    """A setpoint came before the estimator knew the attitude, or alignment took too long."""


class PhysicsDivergedError(RuntimeError):
    """The physics engine gave a state up, because it was infinite or not a number."""


@dataclass(frozen=True, kw_only=True, slots=True)
class PlantCfg:
    """A simulated vehicle below its autopilot: physics, sensors, estimator and inner loops.

    All rates are in Hz and must divide evenly; `check` refuses others.
    """

    seed: int
    """Seed of every random number that the plant draws."""
    gnss: Literal["rtk", "standard"] = "rtk"
    """Grade of the receiver: "rtk" is of decimetres, "standard" of metres."""
    aiding: Literal["gnss", "vio", "mocap", "auto"] = "gnss"
    """Position source: satellites (no fix in rooms), visual-inertial odometry or motion capture;
    auto has satellites and odometry. All but gnss know where they start."""
    imu: Literal["px4", "adis16448"] = "px4"
    """PX4's noise, of a calibrated IMU, or RotorS's, whose biases cost a degree of tilt."""
    state: Literal["estimate", "truth"] = "estimate"
    """State that the controller gets; the truth is for benchmarks of control alone."""
    physics_hz: int = 500
    """Rate of the physics steps, which must be the world's own."""
    control_hz: int = 250
    """Rate of the IMU, the estimator and the controller."""
    advance_hz: int = ADVANCE_HZ
    """Calls of `advance` a simulated second; a setpoint holds until the next call."""
    has_sensors: bool = True
    """False leaves out all sensors and the estimator; `state` must then be "truth"."""
    free_flight: bool = True
    """True lets the kernel integrate a vehicle itself while nothing can touch it, because that is
    faster. Otherwise MuJoCo takes every step. Both give the same flight up to rounding."""
    wind: WindCfg = CALM
    effects: Effects = ALL_EFFECTS
    """Physical effects that are switched on."""
    rotor_axial_limit_mps: float = 25.0
    """Axial speed at which a rotor makes no thrust any more, by the loss at low speeds (PX4's)."""
    barometer: BarometerCfg = field(default_factory=BarometerCfg)
    magnetometer: MagnetometerCfg = field(default_factory=MagnetometerCfg)
    rangefinder: RangefinderCfg = field(default_factory=RangefinderCfg)
    vio: VioCfg = field(default_factory=VioCfg)
    mocap: MocapCfg = field(default_factory=MocapCfg)
    airspeed: AirspeedCfg = field(default_factory=AirspeedCfg)
    optical_flow: OpticalFlowCfg = field(default_factory=OpticalFlowCfg)
    estimator: EstimatorCfg | None = None
    """Tuning of the estimator; None tunes it to the sensors by `estimator_cfg_for`."""
    controller: ControllerCfg | None = None
    """Gains; None takes `autonomy.control.cfg.controller_cfg_for` of the airframe."""

    def has(self, sensor: str) -> bool:
        """Return true if the sensor of this name is switched on at the start.

        Args:
            sensor: Name such as "gnss" or "vio"; sensors that do not measure the position are
                always on, but for the optical flow, which must be fitted.
        """
        if sensor == OPTICAL_FLOW.name:
            return self.optical_flow.is_fitted
        # Sensors that do not measure the position are always on.
        return self.aiding in _AIDED_BY.get(sensor, (self.aiding,))

    def check(self, timestep_s: float) -> None:
        """Check the rates against each other and against the world's physics step.

        Args:
            timestep_s: Physics step of the world.

        Raises:
            PlantError: If they do not divide evenly, or the estimate is wanted without sensors.
        """
        if not 1 <= self.advance_hz <= self.control_hz:
            raise PlantError(f"advance_hz = {self.advance_hz}: 1 to {self.control_hz} are valid")
        if self.control_hz % self.advance_hz or self.control_hz > self.physics_hz:
            raise PlantError(
                f"control_hz = {self.control_hz}: a multiple of {self.advance_hz} up to physics_hz "
                "is valid"
            )
        if self.state == "estimate" and not self.has_sensors:
            raise PlantError("state = 'estimate': without sensors 'truth' is valid")
        if self.physics_hz % self.control_hz:
            raise PlantError(
                f"physics_hz = {self.physics_hz}: a multiple of control_hz "
                f"({self.control_hz}) is valid"
            )
        if abs(timestep_s * self.physics_hz - 1.0) > 1e-9:
            raise PlantError(
                f"physics_hz = {self.physics_hz}: the world steps at {1.0 / timestep_s:g} Hz, "
                "both must be the same"
            )
        for sensor in SENSORS:
            rate = getattr(sensor.cfg(self), "rate_hz", self.control_hz)
            if rate <= 0 or self.control_hz % rate:
                raise PlantError(
                    f"{sensor.setting}.rate_hz = {rate}: a divisor of control_hz "
                    f"({self.control_hz}) is valid"
                )


def estimator_cfg_for(plant: PlantCfg) -> EstimatorCfg:
    """Return the tuning of the estimator that fits the sensors of a plant.

    A tuned estimator is only as honest as its noise figures, so they come from the data sheets that
    the simulated sensors follow. The IMU gets a twentieth more, because integrating its samples
    adds errors. A data sheet may say zero, which no real sensor keeps; floors stand in for that.
    """
    imu, gnss, vio, mocap = IMUS[plant.imu], GRADES[plant.gnss], plant.vio, plant.mocap
    dt_s = 1.0 / plant.control_hz
    mag = plant.magnetometer
    horizontal_ut = math.hypot(FIELD_ENU_UT[0], FIELD_ENU_UT[1])
    gyro_noise, accel_noise = 1.05 * imu.gyro_noise_density, 1.05 * imu.accel_noise_density
    return EstimatorCfg(
        gyro_noise_density=gyro_noise,
        accel_noise_density=accel_noise,
        gyro_bias_walk=max(imu.gyro_bias_walk, 1e-6),
        accel_bias_walk=max(imu.accel_bias_walk, 1e-4),
        initial_tilt_sigma_rad=max(accel_noise / GRAVITY_MPS2, 1e-3),
        initial_yaw_sigma_rad=4e-3,
        initial_gyro_bias_sigma_radps=gyro_noise,
        initial_accel_bias_sigma_mps2=max(imu.accel_turn_on_sigma_mps2, 5e-3),
        heading_sigma_rad=mag.noise_density * math.sqrt(mag.rate_hz) / horizontal_ut,
        # The field of the motors points in a random direction. The part across the Earth's field
        # turns the heading: on average 1/sqrt(3) of it.
        heading_disturbance_rad=mag.motor_ut_per_a
        * _USUAL_CURRENT_A
        / (math.sqrt(3.0) * horizontal_ut),
        # Samples within twice the correlation time share the disturbance, as in `GnssCfg`'s
        # multipath.
        heading_disturbance_samples=2.0 * _DISTURBANCE_LASTS_S * mag.rate_hz,
        baro_sigma_m=1.05 * plant.barometer.noise_pa / _PRESSURE_GRADIENT_PAPM,
        gnss_wander_sigma_m=gnss.drift_sigma_m,
        gnss_wander_correlation_s=gnss.drift_correlation_s,
        max_gnss_step_m=gnss.most_step_m,
        vio_position_walk=vio.position_walk,
        vio_yaw_walk=vio.yaw_walk,
        vio_position_sigma_m=vio.position_noise_m,
        vio_yaw_sigma_rad=vio.yaw_noise_rad,
        mocap_position_sigma_m=mocap.position_noise_m,
        mocap_yaw_sigma_rad=mocap.yaw_noise_rad,
        drag_sigma_mps2=math.hypot(imu.accel_noise_density / math.sqrt(dt_s), 0.03),
    )
