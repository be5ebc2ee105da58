"""Facts about a street or a path from its tags: width, surface, pavements."""

from __future__ import annotations

from typing import Literal

from aeroscene.maps.document import Tags
from aeroscene.maps.tags import length_m, number

LANE_M = 3.0
PAVEMENT_M = 2.0
_STREETS_M = {
    "motorway": 10.0,
    "trunk": 8.0,
    "primary": 7.5,
    "secondary": 7.0,
    "tertiary": 6.5,
    "unclassified": 6.0,
    "residential": 6.0,
    "road": 6.0,
    "living_street": 5.0,
    "busway": 6.5,
    "motorway_link": 5.0,
    "trunk_link": 5.0,
    "primary_link": 5.0,
    "secondary_link": 5.0,
    "tertiary_link": 5.0,
    "service": 4.0,
    "raceway": 8.0,
}
"""Width of a carriageway with traffic in both directions if the map does not state it."""
_PATHS_M = {
    "pedestrian": 6.0,
    "footway": 2.0,
    "path": 1.6,
    "cycleway": 2.4,
    "steps": 2.0,
    "track": 3.0,
    "bridleway": 2.0,
    "platform": 3.0,
}
_RAILS = frozenset({"rail", "light_rail", "narrow_gauge", "preserved", "tram"})
_WITH_PAVEMENTS = frozenset(
    {"primary", "secondary", "tertiary", "unclassified", "residential", "living_street"}
)
"""Streets of towns, which have pavements on both sides unless the map says otherwise."""
_ONE_WAY = 0.65
"""Share of the width of a one-way street."""
_MOST_LANES = 10
_FINISHES = {
    "cobbles": ("sett", "cobblestone", "unhewn_cobblestone", "cobblestone:flattened"),
    "paving": ("paving_stones", "concrete:plates", "bricks", "brick", "tiles"),
    "concrete": ("concrete", "concrete:lanes"),
    "gravel": ("gravel", "fine_gravel", "compacted", "pebblestone", "unpaved", "rock"),
    "soil": ("dirt", "earth", "ground", "mud"),
    "grass": ("grass", "grass_paver"),
    "sand": ("sand",),
    "asphalt": ("asphalt", "chipseal"),
}
Side = Literal["left", "right"]


def is_street(tags: Tags) -> bool:
    """Return true if cars drive on it, above the ground."""
    return tags.get("highway") in _STREETS_M and not _is_hidden(tags)


def is_path(tags: Tags) -> bool:
    """Return true if people walk or ride on it, above the ground."""
    return tags.get("highway") in _PATHS_M and not _is_hidden(tags)


def is_rail(tags: Tags) -> bool:
    """Return true if it is a railway above the ground."""
    return tags.get("railway") in _RAILS and not _is_hidden(tags)


def _is_hidden(tags: Tags) -> bool:
    """Return true if it runs below the ground or inside a building."""
    is_inside = tags.get("indoor") == "yes" or tags.get("location") == "underground"
    return tags.get("tunnel", "no") != "no" or is_inside or (number(tags, "layer", -9, 9) or 0) < 0


def is_hidden_way(tags: Tags) -> bool:
    """Return true for a street, path or railway below the ground or inside a building."""
    kinds = tags.get("highway") in {*_STREETS_M, *_PATHS_M} or tags.get("railway") in _RAILS
    return kinds and _is_hidden(tags)


def street_width_m(tags: Tags) -> float:
    """Width of the carriageway in m, from `width`, `lanes`, or the kind of street.

    Args:
        tags: Tags of a street, see `is_street`.
    """
    for key in ("width:carriageway", "width", "est_width"):
        if (stated := length_m(tags, key, 2.0, 40.0)) is not None:
            return stated
    lanes = number(tags, "lanes", 1, _MOST_LANES)
    if lanes is not None:
        # A single lane is wider than one of several.
        return max(LANE_M * lanes, 3.5)
    usual_m = _STREETS_M[tags["highway"]]
    return max(3.5, _ONE_WAY * usual_m) if tags.get("oneway") == "yes" else usual_m


def path_width_m(tags: Tags) -> float:
    """Width of a path in m, from `width` or its kind; a metre at least.

    Args:
        tags: Tags of a path, see `is_path`.
    """
    stated = length_m(tags, "width", 0.5, 30.0)
    return _PATHS_M[tags["highway"]] if stated is None else max(stated, 1.0)


def pavements(tags: Tags) -> frozenset[Side]:
    """Sides of a street along which a pavement runs."""
    sides: set[Side] = set()
    for side in ("left", "right"):
        said = tags.get(f"sidewalk:{side}", tags.get("sidewalk:both", ""))
        if said in {"yes", "lane"}:
            sides.add(side)
    said = tags.get("sidewalk", tags.get("footway", ""))
    if said in {"left", "right"}:
        sides.add("left" if said == "left" else "right")
    # Silence of the map means pavements in towns; any statement overrules that.
    is_unsaid = not any(key.startswith("sidewalk") for key in tags)
    if said in {"both", "yes"} or (is_unsaid and tags["highway"] in _WITH_PAVEMENTS):
        return frozenset({"left", "right"})
    return frozenset(sides)


def pavement_width_m(tags: Tags) -> float:
    """Width of the pavements along a street, m."""
    stated = [
        length_m(tags, f"sidewalk:{side}:width", 0.8, 10) for side in ("both", "left", "right")
    ]
    return next((width for width in stated if width is not None), PAVEMENT_M)


def finish(tags: Tags, usual: str) -> str:
    """Material of a surface.

    Args:
        tags: Tags of the surface.
        usual: Material if the map states none that we know.
    """
    surface = tags.get("surface", "")
    return next((ours for ours, names in _FINISHES.items() if surface in names), usual)


def has_markings(tags: Tags) -> bool:
    """Return true if lines are painted on the carriageway."""
    is_main = tags["highway"] not in {"service", "living_street"}
    return is_main and tags.get("lane_markings") != "no" and finish(tags, "asphalt") == "asphalt"
