"""PX4's start: parameters of an airframe, which its startup script reads, and the command line."""

from __future__ import annotations

from pathlib import Path

from flightsim.bridges.launch.launch import Launch, Start
from flightsim.vehicles import Airframe

_MODEL, _AUTOSTART = "none_iris", "10016"
"""PX4's quadrotor without a simulator of its own; the parameters below make it ours."""
_FIRST_MOTOR_FUNCTION = 101
_QUADRATIC = 1.0
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
    }


STACK_PORT, OUR_PORT = 13530, 13780
"""UDP ports of a MAVLink link for our recorder and pilot, besides PX4's own links for clients."""
_LINK = f"""#!/bin/sh
. ${{R}}etc/init.d-posix/px4-rc.mavlink
mavlink start -x -u $(({STACK_PORT}+px4_instance)) -r 400000 -f -m onboard \\
  -o $(({OUR_PORT}+px4_instance))
"""


def parameter_file(airframe: Airframe) -> str:
    """Text of a script of parameters, which PX4's startup script runs if it is on the path."""
    own = [f"param set {name} {value:.6g}" for name, value in parameters(airframe).items()]
    return "\n".join(["#!/bin/sh", f"# {airframe.title}", *own, ""])


def launch(
    airframe: Airframe, _start: Start, instance: int, folder: Path, binary: Path | None
) -> Launch:
    """Write the parameters into a folder, and name the command line.

    PX4 takes its place from the first fix. A binary of ours to start keeps its storage and its logs
    in the folder too, with the startup scripts that were built beside it.
    """
    (folder / _PARAMETERS).write_text(parameter_file(airframe), encoding="utf-8")
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
