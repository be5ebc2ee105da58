"""Configuration of an environment, checked before anything is built.

A training may run for days, so a wrong value must fail at once and say what would be valid.
"""

from __future__ import annotations

import functools
import inspect
import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any, Literal, TypeVar, get_args

from flightsim.environment.effects import ALL_EFFECTS
from flightsim.environment.wind import CALM, WindCfg
from flightsim.plant import PlantCfg

ActionLevel = Literal["motors", "rates", "attitude", "velocity", "position"]
StateKind = Literal["true", "estimated", "none"]
CameraName = Literal["forward", "down"]
Segment = Literal["classes", "objects"]
_Cfg = TypeVar("_Cfg")

CONTROL_HZ = 250
_LEAST_PX, _MOST_PX = 8, 320  # bounds of an image's sides
_EFFECTS = replace(ALL_EFFECTS, shelter=False)
"""Effects of an environment. The wind blows from anywhere in each episode, and solving its flow
among buildings would take seconds each time, so shelter is off."""


class EnvironmentInputError(ValueError):
    """A configuration, an action or an option that is not valid: field, value and valid values."""


def _refuses_unknown_fields(prefix: str) -> Callable[[type[_Cfg]], type[_Cfg]]:
    """Let a configuration refuse a field that it does not have, with a list of those it has."""

    def decorate(cls: type[_Cfg]) -> type[_Cfg]:
        # A dataclass would raise a bare TypeError, whose text names neither the value nor the
        # choices.
        initialise, valid = cls.__init__, inspect.signature(cls).parameters

        @functools.wraps(initialise)
        def checked(self: _Cfg, **given: Any) -> None:
            for name, value in given.items():
                if name not in valid:
                    raise EnvironmentInputError(
                        f"{prefix}{name} = {value!r}: it is unknown; {', '.join(valid)} are valid"
                    )
            initialise(self, **given)

        cls.__init__ = checked
        return cls

    return decorate


@_refuses_unknown_fields("observation.")
@dataclass(frozen=True, kw_only=True, slots=True)
class ObservationCfg:
    """Parts of an observation; docs/learning.md lists the numbers of each part."""

    state: StateKind = "true"
    """Velocity, attitude and angular rate: the truth, the estimator's, or not at all."""
    target: bool = True
    """Vector to the target, from the position that `state` knows (the true one without a state)."""
    last_action: bool = False
    """The previous action."""
    imu: bool = False
    """Specific force and angular rate that the IMU measures."""
    range: bool = False
    """Distance that the downward rangefinder measures."""
    depth: tuple[int, int] | None = None
    """Width and height of a depth image in pixels."""
    segments: tuple[Segment, ...] = ()
    """Images beside the depth: the class of each pixel, a key of `flightsim.cameras.CLASS_NAMES`,
    and the object, by its id in the scene."""
    camera: CameraName = "forward"
    """Camera of the images."""

    def __post_init__(self) -> None:
        """Refuse invalid values.

        Raises:
            EnvironmentInputError: Naming the field, its value and the valid values.
        """
        _check_choice("observation.state", self.state, get_args(StateKind))
        _check_choice("observation.camera", self.camera, get_args(CameraName))
        for name in ("target", "last_action", "imu", "range"):
            _check_choice(f"observation.{name}", getattr(self, name), (True, False))
        if self.depth is not None and not _is_size(self.depth):
            raise EnvironmentInputError(
                f"observation.depth = {self.depth!r}: None, or width and height of {_LEAST_PX} to "
                f"{_MOST_PX} pixels, are valid"
            )
        for segment in self.segments:
            _check_choice("observation.segments", segment, get_args(Segment))
        if self.segments and self.depth is None:
            raise EnvironmentInputError(
                f"observation.segments = {self.segments!r} without observation.depth, whose size "
                "they have; valid: a depth such as (64, 64) beside"
            )
        if not self.has_numbers and self.depth is None:
            raise EnvironmentInputError(
                "observation: it has no part; state, target, last_action, imu, range or depth is "
                "needed"
            )

    @property
    def has_numbers(self) -> bool:
        """True if there is anything besides images."""
        return self.state != "none" or self.target or self.last_action or self.imu or self.range

    @property
    def has_sensors(self) -> bool:
        """True if any sensor has to be simulated."""
        return self.state == "estimated" or self.imu or self.range


@_refuses_unknown_fields("randomisation.")
@dataclass(frozen=True, kw_only=True, slots=True)
class RandomisationCfg:
    """Differences between episodes; every draw is uniform, and by default nothing differs."""

    mass: float = 0.0
    """Mass and inertia, up to this share more or less than the controller believes."""
    rotors: float = 0.0
    """Thrust and torque of each rotor, up to this share more or less."""
    wind_mps: float = 0.0
    """Steady wind of up to this speed from anywhere, with its natural turbulence."""
    noise: float = 0.0
    """Noise on a true state, up to this multiple of 0.02 m, 0.05 m/s, 0.01 rad and 0.05 rad/s."""
    latency_s: float = 0.0
    """Greatest time by which actions act later, drawn in whole steps."""

    def __post_init__(self) -> None:
        """Refuse invalid values.

        Raises:
            EnvironmentInputError: Naming the field, its value and the valid values.
        """
        for name, most in (
            ("mass", 0.5),
            ("rotors", 0.3),
            ("wind_mps", 15.0),
            ("noise", 10.0),
            ("latency_s", 0.5),
        ):
            _check_number(f"randomisation.{name}", getattr(self, name), 0.0, most)


@_refuses_unknown_fields("")
@dataclass(frozen=True, kw_only=True, slots=True)
class EnvironmentCfg:
    """An environment besides its task and its scenes."""

    vehicle: str = "iris"
    """Airframe by its name."""
    action: ActionLevel = "rates"
    """Meaning of the four numbers of an action: rotor speeds; thrust and body rates; thrust, roll,
    pitch and turn; velocity and yaw rate; displacement and yaw rate."""
    action_hz: int = 50
    """Steps a simulated second: 250, 125, 50, 25, 10 or 5."""
    episode_s: float | None = None
    """Longest simulated time of an episode; None takes the task's own."""
    observation: ObservationCfg = field(default_factory=ObservationCfg)
    randomisation: RandomisationCfg = field(default_factory=RandomisationCfg)

    def __post_init__(self) -> None:
        """Refuse invalid values.

        Raises:
            EnvironmentInputError: Naming the field, its value and the valid values.
        """
        _check_choice("action", self.action, get_args(ActionLevel))
        _check_choice("action_hz", self.action_hz, (250, 125, 50, 25, 10, 5))
        for name, kind in (("observation", ObservationCfg), ("randomisation", RandomisationCfg)):
            if not isinstance(getattr(self, name), kind):
                raise EnvironmentInputError(
                    f"{name} = {getattr(self, name)!r}: {kind.__name__}(...) is valid"
                )
        if self.episode_s is not None:
            _check_number("episode_s", self.episode_s, 1.0, 600.0)

    def plant_cfg(self, seed: int, wind: WindCfg = CALM) -> PlantCfg:
        """Return the plant of an episode; its inner loops know the same state as the agent."""
        return PlantCfg(
            seed=seed,
            # The inner loops know no more than the agent.
            state="estimate" if self.observation.state == "estimated" else "truth",
            has_sensors=self.observation.has_sensors,
            aiding="auto",
            control_hz=CONTROL_HZ,
            advance_hz=self.action_hz,
            wind=wind,
            effects=_EFFECTS,
        )

    @property
    def longest_latency(self) -> int:
        """Greatest number of steps by which actions may act later."""
        # Rounded down, with tolerance for products such as 0.02 * 50.
        return math.floor(self.randomisation.latency_s * self.action_hz + 1e-9)


def _is_size(size: object) -> bool:
    return (
        isinstance(size, (tuple, list))
        and len(size) == 2
        and all(isinstance(px, int) and _LEAST_PX <= px <= _MOST_PX for px in size)
    )


def _check_choice(name: str, value: object, valid: tuple[object, ...]) -> None:
    if value not in valid:
        raise EnvironmentInputError(f"{name} = {value!r}: {', '.join(map(str, valid))} are valid")


def _check_number(name: str, value: object, low: float, high: float) -> None:
    if not isinstance(value, (int, float)) or isinstance(value, bool) or not low <= value <= high:
        raise EnvironmentInputError(f"{name} = {value!r}: {low:g} to {high:g} are valid")
