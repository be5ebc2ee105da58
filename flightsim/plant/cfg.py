"""Configuration of the plant, and what can be wrong with it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from autonomy.control import ControllerCfg
from autonomy.estimation import EstimatorCfg
from autonomy.model.quadrotor import Vector3
from flightsim.sensors.barometer import BarometerCfg
from flightsim.sensors.imu import ADIS16448, PX4_IMU, ImuCfg
from flightsim.sensors.magnetometer import MagnetometerCfg
from flightsim.sensors.rangefinder import RangefinderCfg

ADVANCE_HZ = 50
"""Calls of `Plant.advance` a simulated second: the rate of everything that is not the plant."""

IMUS = {"px4": PX4_IMU, "adis16448": ADIS16448}


class PlantError(ValueError):
    """A plant that cannot be built as configured."""


class PhysicsDivergedError(RuntimeError):
    """The physics engine met numbers that it could not go on with."""


@dataclass(frozen=True, kw_only=True, slots=True)
class PlantCfg:
    """A simulated vehicle below its autopilot: physics, sensors, estimator and inner loops."""

    seed: int
    """Of every random number that the plant draws."""
    gnss: Literal["rtk", "standard"] = "rtk"
    """Decimetre or metre grade."""
    imu: Literal["px4", "adis16448"] = "px4"
    """PX4's noise, of a calibrated IMU, or RotorS's, whose biases cost a degree of tilt."""
    physics_hz: int = 500
    control_hz: int = 250
    """Rate of the IMU, the estimator and the controller."""
    wind_enu_mps: Vector3 = (0.0, 0.0, 0.0)
    rotor_axial_limit_mps: float = 25.0
    """Axial speed at which a rotor makes no thrust any more (PX4's model)."""
    barometer: BarometerCfg = field(default_factory=BarometerCfg)
    magnetometer: MagnetometerCfg = field(default_factory=MagnetometerCfg)
    rangefinder: RangefinderCfg = field(default_factory=RangefinderCfg)
    estimator: EstimatorCfg | None = None
    """None: tuned to the IMU, `estimator_cfg_for`."""
    controller: ControllerCfg | None = None
    """None: gains for the airframe, `autonomy.control.cfg.controller_cfg_for`."""

    def check(self, timestep_s: float) -> None:
        """Check the rates against each other and against the world's physics step.

        Raises:
            PlantError: If they do not divide evenly.
        """
        if self.control_hz % ADVANCE_HZ or not ADVANCE_HZ <= self.control_hz <= self.physics_hz:
            raise PlantError(
                f"control_hz = {self.control_hz}: a multiple of {ADVANCE_HZ} up to physics_hz is "
                "valid"
            )
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
        for name in ("barometer", "magnetometer", "rangefinder"):
            rate = getattr(self, name).rate_hz
            if rate <= 0 or self.control_hz % rate:
                raise PlantError(
                    f"{name}.rate_hz = {rate}: a divisor of control_hz ({self.control_hz}) is valid"
                )


def estimator_cfg_for(imu: ImuCfg) -> EstimatorCfg:
    """Tuning for an IMU, as by its data sheet: half more noise than it has, and floors."""
    return EstimatorCfg(
        gyro_noise_density=1.5 * imu.gyro_noise_density,
        accel_noise_density=max(1.5 * imu.accel_noise_density, 0.01),
        gyro_bias_walk=max(imu.gyro_bias_walk, 1e-5),
        accel_bias_walk=max(imu.accel_bias_walk, 5e-4),
        initial_accel_bias_sigma_mps2=max(imu.accel_turn_on_sigma_mps2, 0.03),
    )
