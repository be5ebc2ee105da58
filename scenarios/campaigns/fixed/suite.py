"""A fixed suite: scenes, vehicles, trials and recipe in a file that ships, for shipped scenes."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from importlib import resources
from typing import Any

from aeroscene.corpus.shipped import shipped_digest
from scenarios.campaigns.flyer import Trial
from scenarios.tasks.recipe import Recipe, recipe_from


class FixedSuiteError(ValueError):
    """A fixed suite cannot be flown; one line says why, and what would be valid."""


@dataclass(frozen=True, kw_only=True)
class FixedSuite:
    """Trials by which flight stacks are compared."""

    name: str
    version: int
    """Another one has other tasks."""
    scenes_sha256: str
    """Digest of the shipped scenes that its numbers name."""
    scenes: tuple[str, ...]
    vehicles: tuple[str, ...]
    trials: int
    """Trials of each scene with each vehicle."""
    recipe: Recipe

    def all_trials(self) -> list[Trial]:
        """Every trial, scene by scene."""
        return [
            Trial(scene, vehicle, number)
            for scene in self.scenes
            for vehicle in self.vehicles
            for number in range(self.trials)
        ]


def fixed_suites() -> list[FixedSuite]:
    """All that ship, by their names."""
    folder = resources.files("scenarios.campaigns.fixed")
    files = (each for each in folder.iterdir() if each.name.endswith(".toml"))
    plain = {each.name.removesuffix(".toml"): tomllib.loads(each.read_text()) for each in files}
    return [_suite(name, plain[name]) for name in sorted(plain)]


def fixed_suite(name: str) -> FixedSuite:
    """The suite of a name, for the scenes that ship.

    Raises:
        FixedSuiteError: If there is none, or it was made for other scenes.
    """
    suites = {suite.name: suite for suite in fixed_suites()}
    if name not in suites:
        raise FixedSuiteError(f"suite {name!r} is unknown; valid: {', '.join(suites)}")
    if (here := shipped_digest()) != (wanted := suites[name].scenes_sha256):
        raise FixedSuiteError(
            f"suite {name!r} is for the shipped scenes {wanted[:12]}, and these are {here[:12]}; "
            "valid: the release of AeroScene that has them"
        )
    return suites[name]


def _suite(name: str, plain: dict[str, Any]) -> FixedSuite:
    return FixedSuite(
        name=name,
        version=plain["version"],
        scenes_sha256=plain["scenes_sha256"],
        scenes=tuple(str(number) for number in plain["scenes"]),
        vehicles=tuple(plain["vehicles"]),
        trials=plain["trials"],
        recipe=recipe_from(plain["recipe"]),
    )
