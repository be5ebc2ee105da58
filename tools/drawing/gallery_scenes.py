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
        text="Three towers at a crossing; an orange lorry, cars, more of them in a car park.",
        scene="corpus:13",
        generated="39",
    ),
    Place(
        name="residential",
        title="Residential street",
        text="Houses with hipped, gabled and flat roofs around a junction; cars on their drives.",
        scene="corpus:49",
        generated="40",
    ),
    Place(
        name="gardens",
        title="Gardens",
        text="Three houses among trees, lawns, flower beds and basins, where two streets cross.",
        scene="corpus:55",
    ),
    Place(
        name="industrial",
        title="Industrial yard",
        text="A warehouse with rooflights, a crossing, lorries, vans and site huts.",
        scene="corpus:31",
        generated="45",
    ),
    Place(
        name="car-park",
        title="Car park",
        text="Rows of cars on both sides of a street, a coach, canopies with solar panels.",
        scene="corpus:79",
    ),
    Place(
        name="waterfront",
        title="Waterfront",
        text="A quay with a jetty and boats, a square with canopies and a basin, an office.",
        scene="corpus:46",
        generated="49",
    ),
    Place(
        name="terraces",
        title="Lawns by a street",
        text="Lawns with flower beds and conifers, two houses, and a street with cars.",
        scene="corpus:4",
    ),
    Place(
        name="mixed",
        title="Street and rooms",
        text="A mixed scene. A brick house with solar panels and air conditioners on its roof, "
        "whose rooms belong to the scene; behind it a street, beside it a garden with a basin.",
        scene="corpus:12",
    ),
    Place(
        name="office",
        title="Office floor",
        text="Meeting rooms behind glass, tables and shelves; what is above 2.5 m is cut away.",
        scene="corpus:62",
        view="overview",
        cut_height_m=2.5,
        generated="38",
    ),
    Place(
        name="store",
        title="Store",
        text="Racks with boxes, lockers and containers, a counter, a black landing mat and small "
        "rooms along the far wall; cut open likewise.",
        scene="corpus:89",
        view="overview",
        cut_height_m=2.5,
    ),
    Place(
        name="hall",
        title="Hall",
        text="From a gallery with a railing and rows of benches into a hall with windows on two "
        "levels.",
        scene="corpus:83",
        view="inside",
    ),
    Place(
        name="warehouse",
        title="Warehouse",
        text="A gallery with bookshelves, crates and pallets, above racks and containers.",
        scene="corpus:2",
        view="inside",
    ),
)
