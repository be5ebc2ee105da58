"""ArduCopter's start: parameters of an airframe, and the command line of its simulation.

ArduCopter must know how its output becomes thrust and how readily the vehicle turns, else its gains
fit another vehicle. Both follow from the airframe by formulas, so no vehicle needs a file tuned by
hand. The parameters that all vehicles share are in `ardupilot.parm` beside this module.
"""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

from autonomy.control import ControllerCfg
from flightsim.bridges.launch.launch import Launch, Start
from flightsim.vehicles import Airframe

_QUAD, _PLUS, _X = 1, 0, 1
"""ArduCopter's FRAME_CLASS and FRAME_TYPE."""
_RATE_BANDWIDTH_RADPS = 22.0
"""Bandwidth asked of the control of the rates: the proportional gain is this over the vehicle's
angular acceleration at full input."""
_DERIVATIVE_S = 0.027
"""Derivative gain of the rates over their proportional one, ArduCopter's own ratio."""
_SPEEDUP = 1000
"""Speed-up so great that ArduPilot never sleeps: our loop sets the pace of both."""


def parameters(airframe: Airframe) -> dict[str, float]:
    """Return ArduCopter's parameters that follow from an airframe.

    A motor's speed is proportional to its input, from the idle fraction i on. With input u the
    thrust, as a fraction of the greatest, is (i + (1 - i) u)^2. Between idle and full it runs as 2i
    / (1 + i) u + (1 - i) / (1 + i) u^2, which is ArduCopter's curve with MOT_THST_EXPO = (1 - i) /
    (1 + i), so that it inverts ours exactly. The hover throttle is one at sea level: ArduCopter
    adds for thinner air, in which our rotors lose nothing.

    Args:
        airframe: A quadrotor with arms along the axes or on the diagonals.
    """
    idle = ControllerCfg().idle_speed_fraction
    hover = airframe.quadrotor.hover_thrust_fraction
    # ArduCopter's motor 1 lies on the left-right axis of a plus frame, in front of it on an X.
    x, _, _ = airframe.quadrotor.rotors[airframe.motors[0]].position_flu_m
    is_plus = abs(x) < 0.01
    gains = {}
    for axis, letters in enumerate(("RLL", "PIT")):
        gain = _RATE_BANDWIDTH_RADPS / _acceleration_radps2(airframe, axis)
        gains |= {
            f"ATC_RAT_{letters}_P": gain,
            f"ATC_RAT_{letters}_I": gain,
            f"ATC_RAT_{letters}_D": _DERIVATIVE_S * gain,
        }
    return {
        "FRAME_CLASS": _QUAD,
        "FRAME_TYPE": _PLUS if is_plus else _X,
        "MOT_SPIN_ARM": idle,
        "MOT_SPIN_MIN": idle,
        "MOT_SPIN_MAX": 1.0,
        "MOT_THST_EXPO": (1.0 - idle) / (1.0 + idle),
        "MOT_THST_HOVER": (hover - idle**2) / (1.0 - idle**2),
        **gains,
        "BATT_CAPACITY": airframe.battery.capacity_mah,
    }


def _acceleration_radps2(airframe: Airframe, axis: int) -> float:
    """Return the angular acceleration about body x (0) or y (1) by the whole input of the mixer.

    ArduCopter's mixer gives half of a motor's greatest thrust to the motors that lie farthest off
    the axis.
    """
    quadrotor = airframe.quadrotor
    # Rolling (about x) works by the arm along y, and the reverse.
    arms_m = [abs(rotor.position_flu_m[1 - axis]) for rotor in quadrotor.rotors]
    motor_n = quadrotor.max_thrust_n / 4
    torque_nm = sum(0.5 * motor_n * arm_m for arm_m in arms_m)
    return torque_nm / quadrotor.inertia_flu_kgm2[axis]


def parameter_file(airframe: Airframe) -> str:
    """Return the text of a parameter file for an airframe, as `--defaults` takes it."""
    common = (
        files("flightsim.bridges.launch").joinpath("ardupilot.parm").read_text(encoding="utf-8")
    )
    own = [f"{name} {value:.6g}" for name, value in parameters(airframe).items()]
    return "\n".join([common, f"# {airframe.title}", *own, ""])


def launch(
    airframe: Airframe, start: Start, instance: int, folder: Path, _binary: Path | None
) -> Launch:
    """Write the parameter file into a folder, and return the command line that reads it.

    Args:
        airframe: Vehicle to fly.
        start: Its place and heading, which become ArduPilot's home.
        instance: Number that shifts all ports and the MAVLink system id.
        folder: Existing folder for the parameter file.
    """
    path = folder / f"{airframe.name}.parm"
    path.write_text(parameter_file(airframe), encoding="utf-8")
    place = start.place
    home = f"{place.latitude_deg:.8f},{place.longitude_deg:.8f},{place.altitude_m:.3f}"
    return Launch(
        arguments=(
            # --wipe clears the parameters stored by a run before, which would outrank these
            # defaults.
            *("--model", "JSON:127.0.0.1", "--home", f"{home},{start.heading_deg:.2f}"),
            *("--defaults", str(path), "--wipe", "--speedup", str(_SPEEDUP)),
            *("-I", str(instance), "--sysid", str(1 + instance)),
            # 14550 is for ground stations, 14540 for SDKs; serial 2 is our own monitor's (TCP
            # 5763).
            *("--serial0", "tcp:0", "--serial1", f"udpclient:127.0.0.1:{14550 + instance}"),
            *("--serial2", "tcp:3", "--serial5", f"udpclient:127.0.0.1:{14540 + instance}"),
        ),
    )


def clients(instance: int) -> str:
    """Return a line that says at which ports clients find ArduPilot."""
    return (
        f"UDP {14550 + instance} (ground stations), UDP {14540 + instance} (SDKs), "
        f"TCP {5760 + 10 * instance}"
    )
