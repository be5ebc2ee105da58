"""PX4's start: parameters of an airframe, which its startup script reads, and the command line."""

from __future__ import annotations

from pathlib import Path

from flightsim.bridges.launch.launch import Launch, Start
from flightsim.environment.atmosphere import AIR_DENSITY_KGPM3
from flightsim.sensors.gnss import GRADES
from flightsim.vehicles import Airframe
from flightsim.vehicles.rotor_model import drag_model

_MODEL, _AUTOSTART = "none_iris", "10016"
"""PX4's quadrotor without a simulator of its own; the parameters below make it ours."""
_FIRST_MOTOR_FUNCTION = 101
_QUADRATIC = 1.0
_POSITION, _HEIGHT, _VELOCITY, _HEADING = 1, 2, 4, 8
"""Bits of EKF2_EV_CTRL; those of EKF2_GPS_CTRL up to the velocity are longitude and latitude,
height and velocity."""
_BY_GNSS, _BY_ODOMETRY = 1, 3
"""Values of EKF2_HGT_REF."""
_LEAST_ANGLE_NOISE_RAD = 0.05
"""PX4's least EKF2_EVA_NOISE."""
_NO_LOGS = -1
"""Value of SDLOG_MODE."""
_AGAINST_WIND = {
    "MPC_XY_P": 1.5,
    "MPC_XY_VEL_P_ACC": 4.0,
    "MPC_XY_VEL_I_ACC": 2.0,
    "MPC_XY_VEL_D_ACC": 0.5,
    "MPC_TILTMAX_LND": 30.0,
    "MPC_LAND_CRWL": 0.5,
    "LNDMC_Z_VEL_MAX": 0.4,
}
"""Wind of 6 m/s pushes an Iris by 2.6 m/s2. By PX4's own gains it gives way 1.3 m and needs ten
seconds to come back; by these a third of a metre. The 12 degrees to which PX4 limits the tilt until
it has taken off hold 2.1 m/s2, so that it would slide over the ground and drift off. On the ground
it leans against the wind on two legs. It drops onto all four at 0.25 m/s as soon as PX4 has noticed
the contact and takes the thrust away, which must not pass for flight. PX4 bounds that speed by the
one of the last metre down."""
_PARAMETERS = "px4-rc.params"
"""Name under which PX4's startup script looks for parameters of one's own."""


def parameters(airframe: Airframe) -> dict[str, float]:
    """PX4's parameters that follow from an airframe.

    A motor turns at a speed in proportion to its input, so thrust is the square of it, which
    THR_MDL_FAC inverts. Positions are FRD, moments over thrust positive counter-clockwise.
    """
    quadrotor = airframe.quadrotor
    values: dict[str, float] = {"CA_AIRFRAME": 0, "CA_ROTOR_COUNT": 4}
    for motor, rotor in enumerate(airframe.motors):
        params = quadrotor.rotors[rotor]
        x, y, _ = params.position_flu_m
        values |= {
            f"CA_ROTOR{motor}_PX": x,
            f"CA_ROTOR{motor}_PY": -y,
            f"CA_ROTOR{motor}_KM": params.spin * params.torque_per_thrust_m,
            f"PWM_MAIN_FUNC{motor + 1}": _FIRST_MOTOR_FUNCTION + motor,
        }
    return values | {
        "THR_MDL_FAC": _QUADRATIC,
        "MPC_THR_HOVER": quadrotor.hover_thrust_fraction,
        "BAT1_N_CELLS": airframe.battery.cells,
        "BAT1_CAPACITY": airframe.battery.capacity_mah,
        **_AGAINST_WIND,
        **_wind_parameters(airframe),
    }


def _wind_parameters(airframe: Airframe) -> dict[str, float]:
    """Air resistance, by which EKF2 finds the wind: m / CdA of the frame, and that of the rotors.

    Without it EKF2 knows no wind, and takes a steady one for an error of the accelerometer.
    """
    drag = drag_model(airframe)
    along, across = (0.5 * AIR_DENSITY_KGPM3 / share for share in drag.fuselage_per_m)
    hover_radps = airframe.quadrotor.hover_speed_radps
    return {
        "EKF2_DRAG_CTRL": 1,
        "EKF2_BCOEF_X": along,
        "EKF2_BCOEF_Y": across,
        "EKF2_MCOEF": hover_radps * sum(drag.rotor_mps_per_rad),
    }


def sensor_parameters(start: Start) -> dict[str, float]:
    """PX4's parameters that follow from the sensors of a vehicle.

    Heights are the receiver's, but odometry's where that alone says where the vehicle is. There it
    also tells the heading; elsewhere the magnetometer does, whose heading does not drift.
    """
    cfg = start.sensors
    receiver, odometry = GRADES[cfg.gnss], cfg.vio
    has_gnss, has_odometry = cfg.has("gnss"), cfg.has("vio")
    by_odometry = _POSITION | _HEIGHT | (_HEADING if start.is_by_odometry else 0)
    return {
        "SYS_HAS_GPS": int(has_gnss),
        "EKF2_GPS_CTRL": _POSITION | _HEIGHT | _VELOCITY if has_gnss else 0,
        "EKF2_GPS_DELAY": 1e3 * receiver.delay_s,
        "EKF2_GPS_P_NOISE": receiver.reported_accuracy_m[0],
        "EKF2_EV_CTRL": by_odometry if has_odometry else 0,
        "EKF2_EV_DELAY": 1e3 * odometry.delay_s,
        "EKF2_EVP_NOISE": 2.0 * odometry.position_noise_m,
        "EKF2_EVA_NOISE": max(_LEAST_ANGLE_NOISE_RAD, odometry.yaw_noise_rad),
        "EKF2_HGT_REF": _BY_ODOMETRY if start.is_by_odometry else _BY_GNSS,
        "EKF2_OF_CTRL": int(cfg.has("optical_flow")),
    }


STACK_PORT, OUR_PORT = 13530, 13780
"""UDP ports of a MAVLink link for our recorder and pilot, besides PX4's own links for clients."""
_LINK = f"""#!/bin/sh
. ${{R}}etc/init.d-posix/px4-rc.mavlink
# Its links to a camera and to a gimbal, which are not here.
mavlink stop -u $((14280+px4_instance))
mavlink stop -u $((13030+px4_instance))
mavlink start -x -u $(({STACK_PORT}+px4_instance)) -r 400000 -f -m custom \\
  -o $(({OUR_PORT}+px4_instance))
"""


def parameter_file(airframe: Airframe, start: Start, *, keeps_logs: bool = True) -> str:
    """Text of a script of parameters, which PX4's startup script runs if it is on the path."""
    values = parameters(airframe) | sensor_parameters(start)
    if not keeps_logs:
        values["SDLOG_MODE"] = _NO_LOGS
    own = [f"param set {name} {value:.6g}" for name, value in values.items()]
    return "\n".join(["#!/bin/sh", f"# {airframe.title}", *own, ""])


def launch(
    airframe: Airframe, start: Start, instance: int, folder: Path, binary: Path | None
) -> Launch:
    """Write the parameters into a folder, and name the command line.

    PX4 takes its place from the first fix. A binary of ours to start keeps its storage in the
    folder too, with the startup scripts that were built beside it; it writes no logs, which would
    go with the folder.
    """
    script = parameter_file(airframe, start, keeps_logs=binary is None)
    (folder / _PARAMETERS).write_text(script, encoding="utf-8")
    (folder / "px4-rc.mavlink").write_text(_LINK, encoding="utf-8")
    built = () if binary is None else (str(binary.resolve().parent.parent / "etc"),)
    storage = () if binary is None else ("-w", str(folder))
    return Launch(
        arguments=(*built, "-d", "-i", str(instance), *storage),
        environment={
            "PATH": f"{folder}:$PATH",
            "PX4_SIM_MODEL": _MODEL,
            "PX4_SYS_AUTOSTART": _AUTOSTART,
        },
    )


def clients(instance: int) -> str:
    """Where clients find PX4, whose ports for SDKs end at its tenth instance."""
    return f"UDP 14550 (ground stations), UDP {min(14540 + instance, 14549)} (SDKs)"
