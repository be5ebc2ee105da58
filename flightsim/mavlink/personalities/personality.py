"""Personality of a flight stack: its identity, mode numbers, names and encodings."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from flightsim.autopilot.modes import Mode
from flightsim.mavlink.view import VehicleView
from flightsim.plant.external_aids import FixSource

ExtraTelemetry = Callable[[VehicleView], Mapping[str, Callable[[], bytes | None]]]
"""Makes the producers of the messages that only one flight stack sends, by message name."""


@dataclass(frozen=True, kw_only=True)
class ModeEntry:
    """Numbers of one flight mode in a flight stack."""

    mode: Mode
    custom_mode: int
    base_mode: int
    """MAV_MODE_FLAG bits without "armed"."""
    standard_mode: int = 0
    """MAV_STANDARD_MODE; 0 is non-standard."""
    is_selectable: bool = True
    """True if a client may select the mode."""
    also: frozenset[Mode] = frozenset()
    """Modes of ours that belong to this mode of the flight stack, besides `mode`."""
    title: str = ""
    """Name of the mode in the flight stack; empty if it is ours."""

    def reports(self, mode: Mode) -> bool:
        """Return true if a mode of ours may be reported as this one."""
        return mode is self.mode or mode in self.also


@dataclass(frozen=True, kw_only=True)
class Alias:
    """Name, unit, range and default of a parameter in a flight stack."""

    name: str
    ours: str
    """Name of the same parameter in our table."""
    scale: float = 1.0
    """Size of the flight stack's unit in our unit."""
    unit: str = ""
    """The flight stack's unit, for people."""
    is_integer: bool = False
    valid: tuple[float, float] | None = None
    """Least and greatest value in the flight stack's unit; None takes our range."""
    default: float | None = None
    """Default in the flight stack's unit; None takes our default, or the airframe's."""
    codes: Mapping[int, int] = field(default_factory=dict)
    """Our value of each value in the flight stack, for a parameter that is a choice."""
    special: Mapping[float, float] = field(default_factory=dict)
    """Our value of numbers with a meaning of their own, such as 0 for "never"."""
    zero_means: str = ""
    """Alias whose value a 0 stands for; empty if it stands for none."""

    def ours_of(self, value: float) -> float:
        """Return our value of one in the flight stack's unit."""
        if self.codes:
            return self.codes[int(value)]
        return self.special.get(value, value * self.scale)


@dataclass(frozen=True, kw_only=True)
class Setting:
    """A parameter of a flight stack that is no number of our table but a state of the vehicle."""

    name: str
    choices: Mapping[int, str]
    """Meaning of each valid value."""
    read: Callable[[VehicleView], int]
    write: Callable[[VehicleView, int], None]


@dataclass(frozen=True, kw_only=True)
class Personality:
    """Identity, tables and encodings of a flight stack."""

    name: str
    autopilot: int
    """Value of MAV_AUTOPILOT."""
    modes: tuple[ModeEntry, ...]
    """Entries in the order in which they are preferred for reports."""
    mode_shift: Mapping[str, int]
    """Bits by which DO_SET_MODE's "main" and "sub" are shifted into the custom mode."""
    flight_sw_version: int
    flight_custom_version: bytes
    capabilities: int
    """Bits of MAV_PROTOCOL_CAPABILITY."""
    banner: str = ""
    """Text that answers MAV_CMD_DO_SEND_BANNER; empty if the flight stack does not know it."""
    has_bytewise_integers: bool = True
    """True sends integers bytewise in the float field of PARAM_VALUE, false as floats."""
    aliases: tuple[Alias, ...] = ()
    """Parameters under the flight stack's names; none if they are ours."""
    settings: tuple[Setting, ...] = ()
    """Parameters of the flight stack that our table does not have."""
    initial_parameters: Mapping[str, float] = field(default_factory=dict)
    """Our parameters whose defaults differ in the flight stack."""
    pilot_speeds_limit_all: bool = True
    """True lets the greatest climb and descent of the sticks bound automatic flight too."""
    takes_off_above_home: bool = False
    """True counts the altitude of a takeoff from home, instead of as its frame says."""
    acknowledges_set_mode: bool = False
    """True acknowledges the message SET_MODE; a refused mode then counts as FAILED."""
    status_bits: int = 0
    """Bits of MAV_SYS_STATUS_SENSOR that it reports as present, on and healthy, besides ours."""
    turns_to_commanded_heading: bool = True
    """True lets takeoffs and landings turn to the heading of their command."""
    has_guided_mode: bool = False
    """True flies setpoints and single items in the mode of HOLD, instead of in OFFBOARD."""
    switches_fence: bool = False
    """True lets MAV_CMD_DO_FENCE_ENABLE turn the geofence off and on."""
    tests_motors_clockwise: bool = False
    """True counts motor tests clockwise from the nose, instead of by the motors' numbers."""
    has_shell: bool = True
    """True lets SERIAL_CONTROL lead to a shell."""
    has_metadata: bool = True
    """True describes parameters and events in documents, and reports events."""
    requests_int: bool = True
    """True requests uploads of missions with MISSION_REQUEST_INT."""
    n_home_items: int = 0
    """Mission items before the first of the mission: 1 if home is item 0."""
    fix_source: FixSource = FixSource.EITHER
    """Source of satellite fixes at the start."""
    vision_switch: tuple[str, int] = ("EKF2_EV_CTRL", 15)
    """Parameter that lets poses of clients be used, and a value that does."""
    mount_message: str = "MOUNT_ORIENTATION"
    """Message in which older clients read the gimbal's direction."""
    extra_telemetry: ExtraTelemetry = lambda _: {}

    @property
    def parameter_ranges(self) -> Mapping[str, tuple[float, float]]:
        """Range of each of our parameters that the flight stack allows, in our unit."""
        # A value that the stack starts with is valid even beyond our own range.
        initial = {name: (value, value) for name, value in self.initial_parameters.items()}
        return initial | {
            alias.ours: (min(numbers), max(numbers))
            for alias in self.aliases
            if alias.valid is not None
            and (numbers := (*(end * alias.scale for end in alias.valid), *alias.special.values()))
        }

    def entry(self, mode: Mode) -> ModeEntry:
        """Return the preferred entry that reports a mode."""
        return next(entry for entry in self.modes if entry.reports(mode))

    def selectable(self, custom_mode: int) -> ModeEntry | None:
        """Return the selectable entry with a custom mode number; None if there is none."""
        for entry in self.modes:
            if entry.custom_mode == custom_mode and entry.is_selectable:
                return entry
        return None

    def standard(self, standard_mode: int) -> ModeEntry | None:
        """Return the selectable entry with a MAV_STANDARD_MODE; None if there is none."""
        for entry in self.modes:
            # 0 is "non-standard" and names no mode.
            if standard_mode and entry.standard_mode == standard_mode and entry.is_selectable:
                return entry
        return None

    def custom_mode(self, main: int, sub: int) -> int:
        """Return the custom mode number of a DO_SET_MODE.

        Args:
            main: Main mode, the command's second parameter.
            sub: Sub-mode, its third parameter.
        """
        return main << self.mode_shift["main"] | sub << self.mode_shift["sub"]
