"""Districts to order: which options ask for one, and what came of it."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

from aeroscene.corpus.districts.request import SIDE_M, DistrictError, DistrictRequest
from aeroscene.learning.wishes import OBJECTS, OUTLINE_M
from aeroscene.scene import AttributeValue, Scene
from aeroscene.scene.catalogue import BUILDINGS, ROOMS
from scenarios.generation.asked import GenerateError
from scenarios.generation.got import Got

if TYPE_CHECKING:
    from scenarios.generation.draws import Tally

_SHARE = 0.1
"""Share by which numbers of objects and buildings may be missed."""


def is_district(
    outline_m: tuple[float, float] | None,
    n_objects: int | None,
    n_houses: int | None,
    n_storeys: int | None,
) -> bool:
    """Whether wishes are beyond the scene model, which draws sites of up to 150 m."""
    is_wide = outline_m is not None and max(outline_m) > OUTLINE_M.high
    is_full = n_objects is not None and n_objects > OBJECTS.high
    return is_wide or is_full or n_houses is not None or n_storeys is not None


def require_alone(options: Mapping[str, tuple[object, object]]) -> None:
    """Refuse options of the scene model beside a district.

    Args:
        options: Value of each option, and its default.

    Raises:
        GenerateError: If one is not its default.
    """
    for name, (value, usual) in options.items():
        if value != usual:
            shown = f"{value:g}" if isinstance(value, float) else repr(value)
            raise GenerateError(
                f"{name} is {shown} beside a district; valid: the one or the other; an outline "
                f"above {OUTLINE_M.high:g} m, more than {OBJECTS.high} objects, houses and storeys "
                "ask for a district, which the grammar composes"
            )


def district_request(
    seed: int,
    *,
    outline_m: tuple[float, float] | None,
    n_objects: int | None,
    n_houses: int | None,
    n_storeys: int | None,
    n_areas: int | None,
) -> DistrictRequest:
    """Request for a district, refused if the ground has no room for it.

    Raises:
        DistrictError: If a number is out of its range.
    """
    for side_m in outline_m or ():
        if side_m not in SIDE_M:
            raise DistrictError(
                f"outline side {side_m:g} is out of range for a district; valid: {SIDE_M}"
            )
    return DistrictRequest(
        seed=seed,
        outline_m=outline_m,
        n_objects=n_objects,
        n_houses=n_houses,
        n_storeys=n_storeys,
        n_areas=n_areas,
    )


def make_districts(
    requests: Sequence[DistrictRequest], tally: Tally, advance: Callable[[], None]
) -> None:
    """Compose all districts and write what came of them."""
    from aeroscene.corpus.districts import compose_district

    for request in requests:
        began_s = time.perf_counter()
        try:
            scene = compose_district(request)
        except DistrictError as error:
            tally.failed[request.seed] = str(error)
        else:
            tally.write(scene, beside_district(scene))
        tally.seconds += time.perf_counter() - began_s
        advance()


def beside_district(scene: Scene) -> dict[str, Got]:
    """What was asked for of a district beside what it has."""
    got: dict[str, AttributeValue] = {
        "outline": "{:g},{:g}".format(*_sides_m(scene)),
        "objects": len(scene.objects),
        "houses": sum(obj.category in BUILDINGS for obj in scene.objects),
        "storeys": _storeys(scene),
        "areas": len(scene.landing_areas),
    }
    return {
        name: Got(asked, got[name], _is_met(name, asked, got[name]))
        for name, asked in scene.wishes.items()
    }


def _is_met(name: str, asked: AttributeValue, got: AttributeValue) -> bool:
    if not isinstance(asked, (int, float)) or not isinstance(got, (int, float)):
        return asked == got
    if name == "areas":
        return got <= asked
    return got == asked if name == "storeys" else math.isclose(got, asked, rel_tol=_SHARE)


def _storeys(scene: Scene) -> int:
    """Furnished storeys of the tallest building that can be entered: levels of its rooms."""
    levels: dict[int, set[float]] = {}
    for obj in scene.objects:
        if obj.category in ROOMS and obj.parent_id is not None:
            foot_m = obj.bbox.p[2] - obj.bbox.s[2] / 2
            levels.setdefault(obj.parent_id, set()).add(round(foot_m, 1))
    return max(map(len, levels.values()), default=0)


def _sides_m(scene: Scene) -> tuple[float, float]:
    low, high = scene.extent_min_enu_m, scene.extent_max_enu_m
    return (round(high[0] - low[0], 3), round(high[1] - low[1], 3))
