"""Which scenes the gallery shows: for each kind of place the one with most of what marks it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from rich.progress import track

from aeroscene.scene import Scene
from aeroscene.sources import open_scene
from drawing.views import Preset


@dataclass(frozen=True, kw_only=True)
class PlaceKind:
    """A kind of place, how to recognise it and how to show it."""

    name: str
    title: str
    text: str
    domain: str
    signs: Mapping[str, float]
    """Weights of categories by their counts."""
    view: Preset
    cut_height_m: float | None = None


KINDS: tuple[PlaceKind, ...] = (
    PlaceKind(
        name="urban",
        title="Urban block",
        text="Flats and offices over shops, along a street with crossings and parked cars.",
        domain="outdoor",
        signs={"building": 2, "tower": 4, "traffic_light": 1, "house": -2, "boat": -9, "water": -2},
        view="aerial",
    ),
    PlaceKind(
        name="residential",
        title="Residential street",
        text="Houses with pitched roofs, hedges, sheds and cars on their drives.",
        domain="outdoor",
        signs={"house": 3, "garage": 1, "fence": 0.5, "boat": -9, "tower": -3},
        view="aerial",
    ),
    PlaceKind(
        name="park",
        title="Park",
        text="Trees, benches, water and lawns: little to hit from above, much from below.",
        domain="outdoor",
        signs={"tree": 1, "lawn": 2, "bush": 0.4, "bench": 0.6, "building": -2, "car": -0.5},
        view="aerial",
    ),
    PlaceKind(
        name="industrial",
        title="Industrial yard",
        text="Warehouses, stacked containers, pallets, barrels and lorries.",
        domain="outdoor",
        signs={"warehouse": 3, "container": 2, "truck": 1, "pallet": 0.3, "crate": 0.2},
        view="aerial",
    ),
    PlaceKind(
        name="car-park",
        title="Car park",
        text="Rows of cars, many of whose roofs bear a small drone.",
        domain="outdoor",
        signs={"car": 1, "parking_lot": 3, "container": -2, "boat": -9},
        view="aerial",
    ),
    PlaceKind(
        name="waterfront",
        title="Waterfront",
        text="A quay with jetties, boats and goods to be loaded.",
        domain="outdoor",
        signs={"boat": 3, "water": 1, "deck": 0.5},
        view="aerial",
    ),
    PlaceKind(
        name="hillside",
        title="Hillside",
        text="Terraces, ramps and stairs: ground at many heights, and some of it sloping.",
        domain="outdoor",
        signs={"terrain": 2, "stairs": 1.5, "boat": -9},
        view="aerial",
    ),
    PlaceKind(
        name="mixed",
        title="Street and rooms",
        text="A mixed scene: the drone can leave the street through a door or a window.",
        domain="mixed",
        signs={"room": 1, "tree": 0.1, "car": 0.2, "desk": 0.3},
        view="aerial",
    ),
    PlaceKind(
        name="office",
        title="Office floor",
        text="Rooms along corridors; the roof and what is above two and a half metres is cut away.",
        domain="indoor",
        signs={"desk": 1, "monitor": 1, "laptop": 0.5, "bed": -3},
        view="overview",
        cut_height_m=2.5,
    ),
    PlaceKind(
        name="apartments",
        title="Apartments",
        text="Flats with beds, kitchens and sofas, cut open likewise.",
        domain="indoor",
        signs={"bed": 3, "sofa": 1, "stove": 2, "fridge": 2, "shelf": -0.5, "crate": -1},
        view="overview",
        cut_height_m=2.5,
    ),
    PlaceKind(
        name="hall",
        title="Hall",
        text="A high hall, from inside.",
        domain="indoor",
        signs={"landing_pad": 2, "bench": 1, "stairs": 2, "bed": -3, "pallet": -0.4},
        view="inside",
    ),
    PlaceKind(
        name="warehouse",
        title="Warehouse",
        text="Aisles between racks, pallets and crates, from inside.",
        domain="indoor",
        signs={"pallet": 1, "crate": 1, "barrel": 0.5, "shelf": 0.7, "bed": -3, "sofa": -1},
        view="inside",
    ),
)


def choose_scenes(indices: Iterable[int]) -> dict[str, str]:
    """For the name of each kind the corpus scene that shows it best, none twice."""
    specs = [f"corpus:{index}" for index in indices]
    scenes = {spec: open_scene(spec) for spec in track(specs, "scenes")}
    chosen: dict[str, str] = {}
    for kind in KINDS:
        free = [spec for spec in scenes if spec not in chosen.values()]
        chosen[kind.name] = max(free, key=lambda spec: _likeness(kind, scenes[spec]))
    return chosen


def _likeness(kind: PlaceKind, scene: Scene) -> float:
    counts = Counter(obj.category for obj in scene.objects)
    signs = sum(weight * min(counts[name], 24) for name, weight in kind.signs.items())
    return signs - 1e3 * (scene.domain != kind.domain)
