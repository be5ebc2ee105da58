"""Fixed suites and families of tasks that ship, so that everybody's figures are of the same tasks.

A family is a recipe with a name: it tests one ability of a flight stack. A suite names families, or
a recipe of its own, with the scenes, vehicles and numbers of trials that are flown.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

from aeroscene.corpus.shipped import shipped_digest
from scenarios.campaigns.flyer import Trial
from scenarios.tasks.recipe import Recipe, RecipeError, read_recipe, recipe_from

_SUFFIX = ".toml"


class FixedSuiteError(ValueError):
    """A fixed suite cannot be flown; one line says why, and what would be valid."""


@dataclass(frozen=True, kw_only=True)
class SuitePart:
    """Trials of one recipe."""

    family: str
    """Name of the family; empty for the suite's own recipe."""
    scenes: tuple[str, ...]
    vehicles: tuple[str, ...]
    trials: int
    """Number of trials of each scene with each vehicle."""
    recipe: Recipe

    def all_trials(self) -> Iterator[Trial]:
        """Yield every trial, scene by scene."""
        for scene in self.scenes:
            for vehicle in self.vehicles:
                for number in range(self.trials):
                    yield Trial(scene, vehicle, number, self.family)


@dataclass(frozen=True, kw_only=True)
class FixedSuite:
    """Trials that compare flight stacks."""

    name: str
    version: int
    """Version of the suite; another one has other tasks."""
    scenes_sha256: str
    """Digest of the shipped scenes that its numbers name."""
    parts: tuple[SuitePart, ...]

    @property
    def recipe(self) -> Recipe:
        """The suite's own recipe; the default one if all its trials are of families."""
        return next((part.recipe for part in self.parts if not part.family), Recipe())

    @property
    def families(self) -> dict[str, Recipe]:
        """Recipe of each family."""
        return {part.family: part.recipe for part in self.parts if part.family}

    def all_trials(self) -> list[Trial]:
        """Return every trial, part by part."""
        return [trial for part in self.parts for trial in part.all_trials()]


def families() -> dict[str, Recipe]:
    """Return the recipes of the families that ship, by their names."""
    folder = resources.files("scenarios.campaigns.fixed") / "families"
    return {name: recipe_from(plain) for name, plain in _tables(folder).items()}


def named_recipe(name: str) -> Recipe:
    """Return the recipe of a family by its name, or of a TOML file.

    Raises:
        RecipeError: If it is neither, or the file cannot be read.
    """
    known = families()
    if name in known:
        return known[name]
    path = Path(name)
    # A misspelt family should be answered with the list of families, not with a missing file.
    if path.suffix != _SUFFIX and not path.exists():
        raise RecipeError(
            f"recipe {name!r} is no family; valid: {', '.join(known)}, or a file NAME.toml"
        )
    return read_recipe(path)


def fixed_suites() -> list[FixedSuite]:
    """Return all suites that ship, by their names."""
    tables = _tables(resources.files("scenarios.campaigns.fixed"))
    return [_suite(name, plain) for name, plain in tables.items()]


def fixed_suite(name: str) -> FixedSuite:
    """Return the suite of a name, for the scenes that ship.

    Raises:
        FixedSuiteError: If there is none, or it was made for other scenes.
    """
    suites = {suite.name: suite for suite in fixed_suites()}
    if name not in suites:
        raise FixedSuiteError(f"suite {name!r} is unknown; valid: {', '.join(suites)}")
    # Numbers name other scenes in another release, so its figures could not be compared.
    if (here := shipped_digest()) != (wanted := suites[name].scenes_sha256):
        raise FixedSuiteError(
            f"suite {name!r} is for the shipped scenes {wanted[:12]}, and these are {here[:12]}; "
            "valid: the release of AeroScene that has them"
        )
    return suites[name]


def _tables(folder: Traversable) -> dict[str, dict[str, Any]]:
    """Return the TOML files of a folder by their names, in the order of these."""
    files = (each for each in folder.iterdir() if each.name.endswith(_SUFFIX))
    ordered = sorted(files, key=lambda each: each.name)
    return {each.name.removesuffix(_SUFFIX): tomllib.loads(each.read_text()) for each in ordered}


def _suite(name: str, plain: dict[str, Any]) -> FixedSuite:
    # A suite has a recipe of its own, families, or both.
    own = [_part("", plain, recipe_from(plain["recipe"]))] if "recipe" in plain else []
    known = families()
    others = [_part(each, table, known[each]) for each, table in plain.get("families", {}).items()]
    return FixedSuite(
        name=name,
        version=plain["version"],
        scenes_sha256=plain["scenes_sha256"],
        parts=(*own, *others),
    )


def _part(family: str, plain: Mapping[str, Any], recipe: Recipe) -> SuitePart:
    return SuitePart(
        family=family,
        scenes=tuple(str(number) for number in plain["scenes"]),
        vehicles=tuple(plain["vehicles"]),
        trials=plain["trials"],
        recipe=recipe,
    )
