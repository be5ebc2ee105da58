"""Districts to order: options that ask for one, and figures of the result.

The scene model has learnt sites of up to 150 m and 250 objects. Larger wishes go to the grammar
that also composes the corpus: it lays out blocks along streets, and needs no network.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

from aeroscene.corpus.districts.request import SIDE_M, DistrictError, DistrictRequest
from aeroscene.learning.wishes import OBJECTS, OUTLINE_M
from aeroscene.scene import AttributeValue, Scene
from aeroscene.scene.catalogue import BUILDINGS, ROOMS
from scenarios.generation.text_options import GenerateError
from scenarios.generation.wish_outcomes import WishOutcome

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
    """Return true if wishes are beyond the scene model, which draws sites of up to 150 m.

    Args:
        outline_m: Sides of the site, east and north; None if they are not asked for.
        n_objects: Number of objects; None if it is not asked for.
        n_houses: Number of buildings; any number asks for a district.
        n_storeys: Storeys of a tower; any number asks for a district.
    """
    is_wide = outline_m is not None and max(outline_m) > OUTLINE_M.high
    is_full = n_objects is not None and n_objects > OBJECTS.high
    return is_wide or is_full or n_houses is not None or n_storeys is not None


def require_alone(options: Mapping[str, tuple[object, object]]) -> None:
    """Refuse options of the scene model beside a district.

    Args:
        options: Value of each option and its default, by name.

    Raises:
        GenerateError: If one differs from its default.
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
    """Return the request for a district; None for a wish leaves it to the grammar.

    Args:
        seed: Seed of the district.
        outline_m: Sides of the ground, east and north.
        n_objects: Number of objects, met within a tenth.
        n_houses: Number of buildings, met within a tenth.
        n_storeys: Furnished storeys of a tower.
        n_areas: Greatest number of landing areas.

    Raises:
        DistrictError: If a number is out of its range, or the ground has no room for all.
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
    """Compose all districts, and write them and their figures.

    A district that cannot be composed is noted in the tally, and the others follow.

    Args:
        requests: One request for each seed.
        tally: Takes scenes, failures and times.
        advance: Called after each request.
    """
    from aeroscene.corpus.districts import compose_district

    for request in requests:
        # The time of a district includes writing it.
        began_s = time.perf_counter()
        try:
            scene = compose_district(request)
        except DistrictError as error:
            tally.failed[request.seed] = str(error)
        else:
            tally.write(scene, beside_district(scene))
        tally.seconds += time.perf_counter() - began_s
        advance()


def beside_district(scene: Scene) -> dict[str, WishOutcome]:
    """Return each wish for a district beside the figure that the district has.

    Args:
        scene: District, whose document names the wishes.
    """
    measured: dict[str, AttributeValue] = {
        "outline": "{:g},{:g}".format(*_sides_m(scene)),
        "objects": len(scene.objects),
        "houses": sum(obj.category in BUILDINGS for obj in scene.objects),
        "storeys": _storeys(scene),
        "areas": len(scene.landing_areas),
    }
    return {
        name: WishOutcome(requested, measured[name], _is_met(name, requested, measured[name]))
        for name, requested in scene.wishes.items()
    }


def _is_met(name: str, requested: AttributeValue, measured: AttributeValue) -> bool:
    if not isinstance(requested, (int, float)) or not isinstance(measured, (int, float)):
        return requested == measured
    if name == "areas":
        return measured <= requested  # a limit: how many areas there are follows from the geometry
    return (
        measured == requested
        if name == "storeys"
        else math.isclose(measured, requested, rel_tol=_SHARE)
    )


def _storeys(scene: Scene) -> int:
    """Return the furnished storeys of the tallest building, counted by the levels of its rooms."""
    levels: dict[int, set[float]] = {}
    for obj in scene.objects:
        if obj.category in ROOMS and obj.parent_id is not None:
            foot_m = obj.bbox.p[2] - obj.bbox.s[2] / 2
            # Rounded, because floors of one storey may differ by rounding errors.
            levels.setdefault(obj.parent_id, set()).add(round(foot_m, 1))
    return max(map(len, levels.values()), default=0)


def _sides_m(scene: Scene) -> tuple[float, float]:
    low, high = scene.extent_min_enu_m, scene.extent_max_enu_m
    return (round(high[0] - low[0], 3), round(high[1] - low[1], 3))
