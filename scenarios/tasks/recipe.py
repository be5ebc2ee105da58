"""Recipe by which tasks are drawn: a dataclass, and the TOML file that a user writes.

A recipe gives distributions, not tasks. With its seed it determines every task of every scene and
vehicle, so that a campaign can be repeated and extended from a file of a few lines.
"""

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
from flightsim.looks.weather import Season, WeatherError
from flightsim.testbench import TestbenchCfg, TestbenchError
from scenarios.mission.goals import Target
from scenarios.mission.surroundings import MapSource
from scenarios.tasks.drawn_failures import require_failures
from scenarios.tasks.path_difficulty import GRADES, Grade
from scenarios.trials.limits import LIMITS

_MOST_DRAWS = 100
"""Limit of draws. Each draw searches a path through the scene, which takes a tenth of a second."""
_MOST_WORDS = 100
Ends = Literal["any", "indoor", "outdoor", "through"]
Aiding = Literal["gnss", "vio", "mocap", "auto"]
Goal = Literal["area", "naming", "relation", "chain"]
"""Kinds of goals: an area, or a text of one of three grades."""
Range = tuple[float, float]
"""Bounds between which a number is drawn uniformly."""


class RecipeError(TestbenchError):
    """A recipe from which no task can be drawn; one line says why, and what would be valid."""


@dataclass(frozen=True, kw_only=True)
class Recipe:
    """Distributions from which the tasks of a campaign are drawn.

    If several words are allowed, each trial draws one of them with equal chance; a word that is
    named twice is drawn twice as often.
    """

    seed: int = 0
    """Seed of all draws; another one gives other tasks."""
    start: tuple[Literal["own", "area"], ...] = ("own", "area")
    """Start of a flight: the scene's own, or on one of its areas."""
    ends: Ends = "any"
    """Sides of start and target: both indoors, both outdoors, one of each (`through`), or any."""
    target: Target = "landing"
    """Kind of area to land on."""
    goals: tuple[Goal, ...] = ("area",)
    """How the pilot learns its goal: by its area, or by a text of a grade, see docs/goals.md."""
    difficulty: tuple[Grade, ...] = GRADES[::-1]
    """Grades of the paths, which the trials take in turn as far as the scene has them; hard ones
    come first, so that a few trials a scene separate pilots."""
    draws: int = 6
    """Most paths that are measured until one is of the grade whose turn it is."""
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
    """Source of the position, as `aeroscene sitl --aiding` has it; vio denies satellites."""
    failures: tuple[str, ...] = ("none",)
    """Parts that fail in flight, and when, such as gnss+vio=off@2:8 or motor=off@3:10: seconds
    after lift-off between which the moment is drawn."""
    light: tuple[str, ...] = ("afternoon",)
    """Time of day and weather of camera images, as `aeroscene sitl --light` has them; random draws
    another one for each trial."""
    season: tuple[Season, ...] = ("summer",)
    """Season of leaves, grass and the date of the light."""
    navigation_within: float | None = None
    """Most time of the path, in multiples of the least possible one; None for any."""

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
        # Texts are drawn for landing areas only.
        if set(self.goals) != {"area"} and self.target != "landing":
            raise RecipeError(
                f"recipe: target {self.target!r} has no texts; valid: landing, or goals area"
            )
        # "Not at least" instead of "below", so that NaN is refused too.
        if self.navigation_within is not None and not self.navigation_within >= 1.0:
            raise RecipeError(
                f"recipe: navigation_within {self.navigation_within} is out of range; "
                "valid: 1 or more times the least possible time"
            )
        self._try_words()

    def _try_words(self) -> None:
        """Refuse words that the testbench would refuse, before any trial is flown."""
        words: list[dict[str, Any]] = [{"turbulence": word} for word in self.turbulence]
        words += [{"traffic": word} for word in self.traffic]
        words += [{"light": word} for word in self.light]
        words += [{"season": word} for word in self.season]
        # The largest values: if the testbench takes these, it takes all below.
        words.append({"wind": self.wind_mps[1], "gust": self.gust_mps[1]})
        for word in self.failures:
            try:
                require_failures(word)
            except TestbenchError as error:
                raise RecipeError(f"recipe: {error}") from None
        for word in words:
            try:
                TestbenchCfg(**word)
            except (TestbenchError, TrafficError, WeatherError, WindError) as error:
                raise RecipeError(f"recipe: {error}") from None

    def to_plain(self) -> dict[str, Any]:
        """Return the recipe as plain data, which `recipe_from` reads."""
        return asdict(self)


def read_recipe(path: Path) -> Recipe:
    """Read the recipe in a TOML file; fields that it does not name keep their defaults.

    Raises:
        RecipeError: If the file cannot be read or is no recipe.
    """
    try:
        plain = read_toml(path)
    except TomlFileError as error:
        raise RecipeError(f"recipe {str(path)!r}: {error}") from None
    return recipe_from(plain)


def recipe_from(plain: dict[str, Any]) -> Recipe:
    """Return the recipe of plain data, as `Recipe.to_plain` writes it.

    Raises:
        RecipeError: If a name is unknown, or a value is of the wrong kind.
    """
    names = [each.name for each in fields(Recipe)]
    if unknown := sorted(set(plain) - set(names)):
        raise RecipeError(f"recipe: {unknown[0]!r} is unknown; valid: {', '.join(names)}")
    try:
        return msgspec.convert(plain, Recipe)
    except msgspec.ValidationError as error:
        # A check of our own, wrapped by msgspec: its message is the better one.
        if isinstance(error.__cause__, RecipeError):
            raise error.__cause__ from None
        what, _, where = str(error).partition(" - at ")
        field = where.strip("`").removeprefix("$.").partition("[")[0]
        raise RecipeError(
            f"recipe: {field} is {shown(plain.get(field))}: {what[:1].lower()}{what[1:]}"
        ) from None
