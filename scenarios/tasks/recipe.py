"""Recipe by which tasks are drawn: a dataclass, and the TOML file that a user writes."""

from __future__ import annotations

from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any, Literal

import msgspec

from aeroscene.files.bounds import MOST_SEED
from aeroscene.files.toml_file import TomlFileError, read_toml
from aeroscene.files.visible import shown
from flightsim.environment.traffic import TrafficError
from flightsim.environment.wind import WindError
from flightsim.testbench import TestbenchCfg, TestbenchError
from scenarios.mission.goals import Target
from scenarios.mission.surroundings import MapSource
from scenarios.tasks.drawn_failures import require_failures
from scenarios.tasks.way import GRADES, Grade
from scenarios.trials.limits import LIMITS

_MOST_DRAWS = 100
"""Each draw searches a way through the scene, which takes a tenth of a second."""
_MOST_WORDS = 100
Ends = Literal["any", "indoor", "outdoor", "through"]
Aiding = Literal["gnss", "vio", "mocap", "auto"]
Goal = Literal["area", "naming", "relation", "chain"]
"""Kinds of goals: an area, or a text of one of three grades."""
Range = tuple[float, float]
"""Bounds between which a number is drawn, every one with equal chance."""


class RecipeError(TestbenchError):
    """A recipe from which no task can be drawn; one line says why, and what would be valid."""


@dataclass(frozen=True, kw_only=True)
class Recipe:
    """What the tasks of a campaign are drawn from.

    Where several words are allowed, each trial draws one of them with equal chance; a word that is
    named twice is drawn twice as often.
    """

    seed: int = 0
    """Seed of all draws; another one gives other tasks."""
    start: tuple[Literal["own", "area"], ...] = ("own", "area")
    """Where a flight begins: at the scene's own start, or on one of its areas."""
    ends: Ends = "any"
    """Where start and target lie: both indoors, both outdoors, one of each (`through`), or any."""
    target: Target = "landing"
    """What it is to land on."""
    goals: tuple[Goal, ...] = ("area",)
    """How the pilot learns where to land: by its area, or by a text of a grade, see
    docs/goals.md."""
    difficulty: tuple[Grade, ...] = GRADES[::-1]
    """Grades of the ways, which the trials take in turn as far as the scene has them; hard ones
    come first, so that a few trials a scene tell pilots apart."""
    draws: int = 6
    """Ways that are measured at most until one is of the grade whose turn it is."""
    time_limit_s: float = LIMITS.trial_s
    """Simulated time of a trial, up to that of every verdict."""
    wind_mps: Range = (0.0, 5.0)
    """Speed of the steady wind; its direction is any."""
    turbulence: tuple[str, ...] = ("natural",)
    """Dryden turbulence, as `aeroscene sitl --turbulence` has it."""
    gust_mps: Range = (0.0, 0.0)
    """Peak speed of gusts."""
    traffic: tuple[str, ...] = ("none",)
    """Movers, as `aeroscene sitl --traffic` has them."""
    gnss: tuple[Literal["rtk", "standard"], ...] = ("rtk",)
    depth_camera: tuple[Literal["exact", "d435", "d455"], ...] = ("exact",)
    map: tuple[MapSource, ...] = ("truth",)
    aiding: tuple[Aiding, ...] = ("auto",)
    """What measures the position, as `aeroscene sitl --aiding` has it; vio denies satellites."""
    failures: tuple[str, ...] = ("none",)
    """Parts that fail in flight, and when, such as gnss+vio=off@2:8 or motor=off@3:10: seconds
    after lift-off between which the moment is drawn."""
    navigation_within: float | None = None
    """Most time of the way, in multiples of the least possible one; None for any."""

    def __post_init__(self) -> None:
        """Refuse values from which nothing can be drawn.

        Raises:
            RecipeError: Naming the first field that is wrong.
        """
        for each in fields(self):
            value = getattr(self, each.name)
            if isinstance(value, tuple) and not 1 <= len(value) <= _MOST_WORDS:
                raise RecipeError(
                    f"recipe: {each.name} has {len(value)} values; valid: 1 to {_MOST_WORDS}"
                )
        for name in ("wind_mps", "gust_mps"):
            low, high = getattr(self, name)
            if not 0.0 <= low <= high < float("inf"):
                raise RecipeError(
                    f"recipe: {name} {[low, high]} is no range; valid: [LOW, HIGH] from 0 m/s"
                )
        for name, low, high in (("seed", 0, MOST_SEED), ("draws", 1, _MOST_DRAWS)):
            if not low <= (value := getattr(self, name)) <= high:
                raise RecipeError(
                    f"recipe: {name} {shown(value)} is out of range; valid: {low} to {high}"
                )
        if not 0.0 < self.time_limit_s <= LIMITS.trial_s:
            raise RecipeError(
                f"recipe: time_limit_s {self.time_limit_s} is out of range; "
                f"valid: above 0, at most {LIMITS.trial_s:g}"
            )
        if set(self.goals) != {"area"} and self.target != "landing":
            raise RecipeError(
                f"recipe: target {self.target!r} has no texts; valid: landing, or goals area"
            )
        if self.navigation_within is not None and not self.navigation_within >= 1.0:
            raise RecipeError(
                f"recipe: navigation_within {self.navigation_within} is out of range; "
                "valid: 1 or more times the least possible time"
            )
        self._try_words()

    def _try_words(self) -> None:
        """Refuse what the testbench would refuse."""
        words: list[dict[str, Any]] = [{"turbulence": word} for word in self.turbulence]
        words += [{"traffic": word} for word in self.traffic]
        words.append({"wind": self.wind_mps[1], "gust": self.gust_mps[1]})
        for word in self.failures:
            try:
                require_failures(word)
            except TestbenchError as error:
                raise RecipeError(f"recipe: {error}") from None
        for word in words:
            try:
                TestbenchCfg(**word)
            except (TestbenchError, TrafficError, WindError) as error:
                raise RecipeError(f"recipe: {error}") from None

    def to_plain(self) -> dict[str, Any]:
        """The recipe as plain data."""
        return asdict(self)


def read_recipe(path: Path) -> Recipe:
    """Read the recipe in a TOML file; what it does not name keeps its default.

    Raises:
        RecipeError: If it cannot be read, or is none.
    """
    try:
        plain = read_toml(path)
    except TomlFileError as error:
        raise RecipeError(f"recipe {str(path)!r}: {error}") from None
    return recipe_from(plain)


def recipe_from(plain: dict[str, Any]) -> Recipe:
    """Recipe of plain data, as `Recipe.to_plain` writes it.

    Raises:
        RecipeError: If a name is unknown, or a value is of the wrong kind.
    """
    names = [each.name for each in fields(Recipe)]
    if unknown := sorted(set(plain) - set(names)):
        raise RecipeError(f"recipe: {unknown[0]!r} is unknown; valid: {', '.join(names)}")
    try:
        return msgspec.convert(plain, Recipe)
    except msgspec.ValidationError as error:
        if isinstance(error.__cause__, RecipeError):
            raise error.__cause__ from None
        what, _, where = str(error).partition(" - at ")
        field = where.strip("`").removeprefix("$.").partition("[")[0]
        raise RecipeError(
            f"recipe: {field} is {shown(plain.get(field))}: {what[:1].lower()}{what[1:]}"
        ) from None
