"""What a generated scene has beside what was asked for, wish by wish.

The model is told the wishes and follows them as well as it has learnt to. A site of 150 m by 150 m
is rare in its training scenes, so that it may draw a smaller one. The user reads it here.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from aeroscene.feasibility.wishes.clutter import clutter_factor
from aeroscene.scene import AttributeValue, Scene
from scenarios.generation.prompts.demands import numbers_of
from scenarios.generation.prompts.wishes import Count

if TYPE_CHECKING:
    from aeroscene.learning.generation import Generated

_OBJECTS_SHARE = 0.2
"""Share by which a number of objects may be missed. The help says "approximate"; the model is
within it in 96% of outdoor scenes."""
_OUTLINE_SHARE = 0.1
"""Share by which a side of the site may be missed: flights keep a margin beyond the site."""
_LENGTH_M = 0.01
"""Lengths are told to the centimetre."""


@dataclass(frozen=True, slots=True)
class Got:
    """A wish beside what came of it."""

    asked: AttributeValue
    got: AttributeValue | None
    """None where there is nothing to measure, such as no passage."""
    is_met: bool
    off: float = 0.0
    """Share by which a count misses what was asked for."""

    def to_plain(self) -> dict[str, AttributeValue | None]:
        """The wish as plain data."""
        return {"asked": self.asked, "got": self.got, "met": self.is_met}


def beside_wishes(found: Generated, scene: Scene) -> dict[str, Got]:
    """Every wish that can be measured beside what the scene has.

    Args:
        found: The draw.
        scene: Its scene as it is kept, with what was measured on the way.
    """
    asked = dict(scene.wishes)
    rows = (
        ("theme", scene.theme, scene.theme == asked.get("theme")),
        ("objects", *_objects(asked, scene)),
        ("outline", *_outline(found, scene)),
        *_areas(asked, scene),
        ("density", *_density(found, scene)),
        ("clutter", *_clutter(found, scene)),
        ("min_passage", *_passage(asked, scene)),
        ("difficulty", *_difficulty(asked, scene)),
    )
    return {name: Got(asked[name], got, ok) for name, got, ok in rows if name in asked}


def beside_demands(scene: Scene, demands: Sequence[Count]) -> dict[str, Got]:
    """Counts and relations that a prompt asks for beside what the scene has, by their titles."""
    return {
        demand.title: Got(demand.number, n, demand.is_met(n), demand.off(n))
        for demand, n in numbers_of(scene, demands)
    }


def with_demands(scene: Scene, prompt: str, demands: Sequence[Count]) -> Scene:
    """The scene whose document names the prompt and what it counts among the wishes."""
    asked: dict[str, AttributeValue] = {each.title: each.number for each in demands}
    prompted: dict[str, AttributeValue] = {"prompt": prompt} if prompt else {}
    return replace(scene, wishes={**scene.wishes, **prompted, **asked})


def shortfall(wishes: Mapping[str, Got]) -> tuple[int, float]:
    """Order of draws, the best first: wishes that are missed, then by how much."""
    return sum(not each.is_met for each in wishes.values()), sum(w.off for w in wishes.values())


def with_measures(scene: Scene, wishes: Mapping[str, Got]) -> Scene:
    """The scene whose document names what was got of every wish."""
    got = {name: wish.got for name, wish in wishes.items() if wish.got is not None}
    return replace(scene, measured={**got, **scene.measured})


def unmet(wishes: Mapping[str, Got]) -> str:
    """The wishes that were not met, in words; empty if all were."""
    return ", ".join(
        f"{name} {'none' if wish.got is None else wish.got} where {wish.asked} was asked for"
        for name, wish in wishes.items()
        if not wish.is_met
    )


_Measure = tuple[AttributeValue | None, bool]
"""What was got, and whether that meets the wish."""


def _objects(asked: Mapping[str, AttributeValue], scene: Scene) -> _Measure:
    n = len(scene.objects)
    return n, _is_about(n, asked.get("objects"), _OBJECTS_SHARE)


def _outline(found: Generated, scene: Scene) -> _Measure:
    low, high = scene.extent_min_enu_m, scene.extent_max_enu_m
    sides_m = [high[axis] - low[axis] for axis in (0, 1)]
    is_met = all(
        _is_about(got, asked, _OUTLINE_SHARE)
        for got, asked in zip(sides_m, found.request.outline_m or sides_m, strict=True)
    )
    return ",".join(f"{side:.1f}" for side in sides_m), is_met


def _areas(
    asked: Mapping[str, AttributeValue], scene: Scene
) -> Iterator[tuple[str, AttributeValue, bool]]:
    """Numbers of landing areas, which wishes bound from above."""
    classes = [area.drone_class for area in scene.landing_areas]
    counts = {f"areas_{name}": classes.count(name) for name in ("small", "medium", "large")}
    for name, n in {"areas": len(classes), **counts}.items():
        most = asked.get(name)
        yield name, n, not isinstance(most, (int, float)) or n <= most


def _density(found: Generated, scene: Scene) -> _Measure:
    """The factor on the usual number of fine objects that has come out."""
    asked, redo = found.request.density, found.request.redo
    if asked is None:
        return None, True
    n_kept = 0 if redo is None else redo.n_kept_fine
    n_fine = sum(not obj.is_coarse for obj in scene.objects) - n_kept
    got = asked * n_fine / max(1, found.wish.n_fine - n_kept)
    return round(got, 2), _is_about(got, asked, _OBJECTS_SHARE)


def _clutter(found: Generated, scene: Scene) -> _Measure:
    asked = found.request.clutter
    if asked is None:
        return None, True
    got = clutter_factor(found.raw, scene)
    return round(got, 2), got >= (1.0 - _OBJECTS_SHARE) * asked


def _passage(asked: Mapping[str, AttributeValue], scene: Scene) -> _Measure:
    """The narrowest passage; a scene without passages has none that is too narrow."""
    got, least_m = scene.measured.get("min_passage"), asked.get("min_passage")
    if not isinstance(got, (int, float)) or not isinstance(least_m, (int, float)):
        return None, True
    return got, got >= least_m - _LENGTH_M


def _difficulty(asked: Mapping[str, AttributeValue], scene: Scene) -> _Measure:
    got = scene.measured.get("difficulty")
    return got, got == asked.get("difficulty")


def _is_about(got: float, asked: AttributeValue | None, share: float) -> bool:
    return not isinstance(asked, (int, float)) or abs(got - asked) <= share * asked
