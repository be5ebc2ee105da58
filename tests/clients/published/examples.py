"""The published examples, and how each of them ends."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path


@dataclass(frozen=True, kw_only=True)
class Example:
    """A published example, and how it ends."""

    name: str
    says: str = ""
    """What it prints on its way, a regular expression."""
    is_endless: bool = False
    """Whether it never ends by itself, so that going on without a fault is its end."""
    is_quiet: bool = False
    """Whether it leaves the vehicle as it was, so that the next example may have it."""
    folder: str = ""
    """Folder of its own among the examples."""
    edits: Mapping[str, str] = field(default_factory=dict)
    """What of its source is replaced, besides its address."""
    options: Sequence[str] = ()
    """Options of a testbench of its own."""
    follows: str = ""
    """Name of the example that flies its vehicle first, where it wants one that has flown."""
    but: str | None = None
    """Why it does not finish here; None where it does."""
    raises: str = ""
    """What it raises then, a regular expression."""

    def path(self, examples: Path) -> Path:
        """Its script within the folder of the examples."""
        return examples / self.folder / f"{self.name}.py"


def _examples(*examples: Example) -> dict[str, Example]:
    return {example.name: example for example in examples}


EXAMPLES = _examples(
    Example(name="takeoff_and_land", says="-- Landing"),
    Example(name="logfile_download", follows="takeoff_and_land", says="Downloading"),
    # It asks for the firmware of an I/O board, which no simulator has; this is the same log.
    Example(
        name="ftp_download_file",
        follows="takeoff_and_land",
        says=r"Got (\d+) of \1 bytes",
        edits={"/etc/extras/px4_io-v2_default.bin": "/log/0.ulg"},
    ),
    Example(name="mission", says="Mission progress: 3/3"),
    Example(name="goto", is_endless=True, says="Staying connected"),
    Example(name="offboard_position_ned", says="Stopping offboard"),
    Example(name="offboard_velocity_ned", says="Stopping offboard"),
    Example(name="offboard_velocity_body", says="Stopping offboard"),
    Example(name="offboard_attitude", says="Stopping offboard"),
    Example(name="offboard_position_velocity_ned", says="Stopping offboard"),
    Example(name="offboard_from_csv", folder="offboard_from_csv", says="-- Disarming"),
    Example(name="do_orbit", says="--- Landing"),
    Example(name="geofence", says="Geofence uploaded!"),
    Example(name="follow_me_example", says="-- Landing"),
    Example(name="manual_control", is_endless=True, says="Starting manual control"),
    Example(name="telemetry_takeoff_and_land", says="Altitude: 2"),
    Example(name="telemetry", is_quiet=True, is_endless=True, says="Position: "),
    Example(
        name="telemetry_flight_mode",
        is_quiet=True,
        is_endless=True,
        says="FlightMode: HOLD",
    ),
    Example(
        name="telemetry_is_armed_is_in_air",
        is_quiet=True,
        is_endless=True,
        says="Is_in_air: False",
    ),
    Example(
        name="telemetry_status_text",
        is_quiet=True,
        is_endless=True,
        says="Connected to drone",
    ),
    Example(name="highres_imu", is_quiet=True, is_endless=True, says="Temperature"),
    Example(name="firmware_version", is_quiet=True, says="flight_sw_major"),
    Example(name="all_params", is_quiet=True, says="MIS_TAKEOFF_ALT"),
    Example(name="mission_import", is_quiet=True, says="Mission uploaded"),
    Example(name="mission_raw", is_quiet=True, says="-- Done"),
    Example(name="failure_injection", says="Disabling failure injection"),
    Example(name="ftp_list_dir", is_quiet=True, says="directory list"),
    Example(name="shell", is_quiet=True, is_endless=True, says="nsh> "),
    Example(name="send_status_message", is_quiet=True, says="Connected to drone"),
    Example(name="tune", is_quiet=True, says="Tune played"),
    Example(
        name="mavlink_direct_receive", is_quiet=True, is_endless=True, says=r"ATTITUDE from \d+/1"
    ),
    Example(name="mavlink_direct_send", is_quiet=True, says="Sending airspeed 19"),
    Example(name="px4_ev_automation", is_quiet=True, is_endless=True, says="Flight Mode: "),
    Example(name="rtcm", is_quiet=True),
    Example(
        name="transponder",
        is_quiet=True,
        is_endless=True,
        says="icao_address",
        options=("--traffic", "drones=1"),
    ),
    Example(
        name="calibration",
        is_quiet=True,
        says="Board level calibration finished",
        but="the accelerometer wants the vehicle turned by hand",
        raises="CalibrationError: .*calibrate_accelerometer",
    ),
    Example(
        name="camera",
        is_quiet=True,
        says="Camera mode: PHOTO",
        but="it calls the camera as MAVSDK 2 had it, without naming which",
        raises=r"TypeError: Camera\.set_mode\(\) missing",
    ),
    Example(
        name="gimbal",
        is_quiet=True,
        says="Release control",
        but="it waits for the end of the list of gimbals, which has none",
        raises="TypeError: 'NoneType' object is not iterable",
    ),
    Example(
        name="gripper",
        is_quiet=True,
        is_endless=True,
        says="Staying connected",
        but="there is no gripper",
        raises="GripperError",
    ),
    Example(
        name="winch",
        is_quiet=True,
        is_endless=True,
        says="Staying connected",
        but="there is no winch",
        raises="WinchError",
    ),
)

NOT_RUN: Mapping[str, str] = {
    "camera_params": "asks at the keyboard what to set",
    "px4_ev_automation_keyboard": "asks at the keyboard what to set",
    "rtk_base_ublox": "reads a satellite receiver on a serial port",
    "show_debug_output": "connects to an address that is wrong on purpose",
    "upload_params": "takes a file of parameters, of which none is published",
}
"""The other published examples, and why they are not run."""
