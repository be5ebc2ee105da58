"""Scenes that the gallery shows, the view of each, and the words below it."""

from __future__ import annotations

from dataclasses import dataclass

from drawing.views import Preset


@dataclass(frozen=True, kw_only=True)
class Place:
    """A curated scene to show, and a generated one of its kind to show beside it."""

    name: str
    title: str
    text: str
    """Description of the picture, checked by eye: it has to change with the scene."""
    scene: str
    view: Preset = "aerial"
    cut_height_m: float | None = None
    generated: str | None = None
    """Number of a shipped scene of the same kind; None shows the curated one alone."""


PLACES: tuple[Place, ...] = (
    Place(
        name="urban",
        title="Urban block",
        text="Houses with shops stand wall to wall along a street; a pedestrian crossing, and a "
        "square with a canopy and a landing mark.",
        scene="corpus:13",
        generated="39",
    ),
    Place(
        name="old-town",
        title="Old town",
        text="Narrow houses with shops below and flat and pitched roofs above, air conditioners on "
        "one of them.",
        scene="corpus:55",
        generated="37",
    ),
    Place(
        name="residential",
        title="Residential street",
        text="Row houses and single ones along a street with cars and a lorry; a pond behind a "
        "hedge.",
        scene="corpus:48",
        generated="40",
    ),
    Place(
        name="industrial",
        title="Industrial yard",
        text="A hall with rooflights at a crossing; lorries and cars in the yard, a red office, "
        "and gardens across the street.",
        scene="corpus:79",
        generated="45",
    ),
    Place(
        name="waterfront",
        title="Waterfront",
        text="A square with trees and market stalls at the water, a sailing boat, a tower and "
        "brick houses.",
        scene="corpus:46",
        generated="49",
    ),
    Place(
        name="hillside",
        title="Hillside",
        text="A street with cars below gardens and houses with red roofs.",
        scene="corpus:4",
    ),
    Place(
        name="mixed",
        title="Street and rooms",
        text="A mixed scene. The rooms of the brick house belong to the scene; houses with shops "
        "stand across the street.",
        scene="corpus:12",
    ),
    Place(
        name="office",
        title="Office floor",
        text="Meeting rooms behind glass, desks and shelves; what is above 2.5 m is cut away.",
        scene="corpus:62",
        view="overview",
        cut_height_m=2.5,
        generated="44",
    ),
    Place(
        name="apartments",
        title="Apartments",
        text="Flats around a hall with a landing pad: living rooms, kitchens, bathrooms, bedrooms; "
        "cut open likewise.",
        scene="corpus:44",
        view="overview",
        cut_height_m=2.5,
        generated="47",
    ),
    Place(
        name="store",
        title="Supermarket",
        text="Rows of shelves, a green landing mat, and small rooms along the far wall; cut open "
        "likewise.",
        scene="corpus:89",
        view="overview",
        cut_height_m=2.5,
    ),
    Place(
        name="warehouse",
        title="Warehouse",
        text="Pallets with bricks and boxes, racks behind them, and the railing of a gallery.",
        scene="corpus:29",
        view="inside",
    ),
)
