"""PX4's start: parameters of an airframe and its sensors, and the command line.

PX4's startup script reads a file of parameters if it finds one on the path, so a folder put at the
head of PATH makes any build of PX4 fly our vehicle; no airframe has to be built into it. The
parameters say how the motors act, how the air resists, and which sensors EKF2, PX4's estimator, may
fuse. docs/flight_stacks.md lists those that differ from PX4's own, with the measurements behind
them.
"""

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
"""PX4's number for the output of motor 1; the others count up from it."""
_QUADRATIC = 1.0
"""Value of THR_MDL_FAC for a thrust that goes with the square of the output."""
_POSITION, _HEIGHT, _VELOCITY, _HEADING = 1, 2, 4, 8
"""Bits of EKF2_EV_CTRL. In EKF2_GPS_CTRL the same three bits up to the velocity mean longitude and
latitude, height, and velocity."""
_BY_GNSS, _BY_ODOMETRY = 1, 3
"""Values of EKF2_HGT_REF, which names the sensor whose height the estimate follows."""
_LEAST_ANGLE_NOISE_RAD = 0.05
"""Least value that PX4 takes for EKF2_EVA_NOISE."""
_NO_LOGS = -1
"""Value of SDLOG_MODE that writes none."""
_AGAINST_WIND = {
    "MPC_XY_P": 1.5,
    "MPC_XY_VEL_P_ACC": 4.0,
    "MPC_XY_VEL_I_ACC": 2.0,
    "MPC_XY_VEL_D_ACC": 0.5,
    "MPC_TILTMAX_LND": 30.0,
    "MPC_LAND_CRWL": 0.5,
    "LNDMC_Z_VEL_MAX": 0.4,
}
"""Parameters with which PX4 holds its place in wind.

Wind of 6 m/s pushes an Iris by 2.6 m/s2. With PX4's own gains it gives way 1.3 m and needs ten
seconds to come back; with these a third of a metre. The 12 degrees to which PX4 limits the tilt
until it has taken off hold 2.1 m/s2, so it would slide over the ground and drift off.

A vehicle that lands leans against the wind on two legs. It drops onto all four at 0.25 m/s as soon
as PX4 has noticed the contact and takes the thrust away. LNDMC_Z_VEL_MAX lies above that speed, so
that the drop does not pass for flight, and MPC_LAND_CRWL above it, since PX4 bounds the one by the
other, its speed of the last metre down.
"""
_PARAMETERS = "px4-rc.params"
"""Name under which PX4's startup script looks for a user's own parameters."""


def parameters(airframe: Airframe) -> dict[str, float]:
    """Return PX4's parameters that follow from an airframe.

    A motor's speed is proportional to its input, so thrust is the square of the input, which
    THR_MDL_FAC inverts.
    """
    quadrotor = airframe.quadrotor
    values: dict[str, float] = {"CA_AIRFRAME": 0, "CA_ROTOR_COUNT": 4}
    for motor, rotor in enumerate(airframe.motors):
        params = quadrotor.rotors[rotor]
        x, y, _ = params.position_flu_m
        values |= {
            f"CA_ROTOR{motor}_PX": x,
            f"CA_ROTOR{motor}_PY": -y,  # FRD: y to the right
            # In the FRD frame, a counter-clockwise rotor's is positive.
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
    """Return the parameters of air resistance, by which EKF2 finds the wind.

    The ballistic coefficients are m / (Cd A) of the fuselage in kg/m2, and EKF2_MCOEF is the drag
    of the rotors at hover speed per mass and airspeed, in 1/s. Without them EKF2 knows no wind, and
    takes a steady one for an error of the accelerometer.
    """
    drag = drag_model(airframe)
    # The fuselage's deceleration is share * v^2, and EKF2's is 0.5 rho v^2 over the coefficient.
    along, across = (0.5 * AIR_DENSITY_KGPM3 / share for share in drag.fuselage_per_m)
    hover_radps = airframe.quadrotor.hover_speed_radps
    return {
        "EKF2_DRAG_CTRL": 1,
        "EKF2_BCOEF_X": along,
        "EKF2_BCOEF_Y": across,
        "EKF2_MCOEF": hover_radps * sum(drag.rotor_mps_per_rad),
    }


def sensor_parameters(start: Start) -> dict[str, float]:
    """Return PX4's parameters that follow from the sensors of a vehicle.

    Heights are the receiver's, but odometry's where that alone gives the position. There odometry
    gives the heading too; elsewhere the magnetometer does, whose heading does not drift.
    """
    cfg = start.sensors
    receiver, odometry = GRADES[cfg.gnss], cfg.vio
    has_gnss, has_odometry = cfg.has("gnss"), cfg.has("vio")
    by_odometry = _POSITION | _HEIGHT | (_HEADING if start.is_by_odometry else 0)
    return {
        "SYS_HAS_GPS": int(has_gnss),
        "EKF2_GPS_CTRL": _POSITION | _HEIGHT | _VELOCITY if has_gnss else 0,
        "EKF2_GPS_DELAY": 1e3 * receiver.delay_s,  # ms, as all of EKF2's delays
        "EKF2_GPS_P_NOISE": receiver.reported_accuracy_m[0],
        "EKF2_EV_CTRL": by_odometry if has_odometry else 0,
        "EKF2_EV_DELAY": 1e3 * odometry.delay_s,
        "EKF2_EVP_NOISE": 2.0 * odometry.position_noise_m,
        "EKF2_EVA_NOISE": max(_LEAST_ANGLE_NOISE_RAD, odometry.yaw_noise_rad),
        "EKF2_HGT_REF": _BY_ODOMETRY if start.is_by_odometry else _BY_GNSS,
        "EKF2_OF_CTRL": int(cfg.has("optical_flow")),
    }


STACK_PORT, OUR_PORT = 13530, 13780
"""UDP ports of a MAVLink link for our monitor and pilot, besides PX4's own links for clients."""
_LINK = f"""#!/bin/sh
. ${{R}}etc/init.d-posix/px4-rc.mavlink
# Its links to a camera and to a gimbal, which are not here.
mavlink stop -u $((14280+px4_instance))
mavlink stop -u $((13030+px4_instance))
mavlink start -x -u $(({STACK_PORT}+px4_instance)) -r 400000 -f -m custom \\
  -o $(({OUR_PORT}+px4_instance))
"""


def parameter_file(airframe: Airframe, start: Start, *, keeps_logs: bool = True) -> str:
    """Return a script of parameters, which PX4's startup script runs if it finds it on the path.

    Args:
        airframe: Vehicle to fly.
        start: Its place and sensors.
        keeps_logs: False has PX4 write no flight logs of its own.
    """
    values = parameters(airframe) | sensor_parameters(start)
    if not keeps_logs:
        values["SDLOG_MODE"] = _NO_LOGS
    own = [f"param set {name} {value:.6g}" for name, value in values.items()]
    return "\n".join(["#!/bin/sh", f"# {airframe.title}", *own, ""])


def launch(
    airframe: Airframe, start: Start, instance: int, folder: Path, binary: Path | None
) -> Launch:
    """Write the parameters into a folder, and return the command line that finds them there.

    PX4 takes its place from the first fix, so none is passed. A binary that we start keeps its
    storage in the folder too, and reads the startup scripts that were built beside it. It writes no
    logs, which would be removed with the folder.

    Args:
        airframe: Vehicle to fly.
        start: Its place and sensors.
        instance: Number that shifts all ports.
        folder: Existing folder for the scripts.
        binary: Program that we are to start; None if the user starts one.
    """
    script = parameter_file(airframe, start, keeps_logs=binary is None)
    (folder / _PARAMETERS).write_text(script, encoding="utf-8")
    (folder / "px4-rc.mavlink").write_text(_LINK, encoding="utf-8")
    # A build has bin/px4 and etc/ side by side.
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
    """Return a line that says where clients find PX4; its SDK ports end at the tenth instance."""
    return f"UDP 14550 (ground stations), UDP {min(14540 + instance, 14549)} (SDKs)"
