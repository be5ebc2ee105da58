from __future__ import annotations

from collections import Counter
from functools import cache
from math import cos, pi

import numpy as np
import pytest

from aeroscene.corpus.curation.builder import Builder
from aeroscene.corpus.curation.composers import themes
from aeroscene.corpus.curation.draw import Draw
from aeroscene.corpus.curation.frame import Frame
from aeroscene.corpus.curation.parcels import Parcel
from aeroscene.corpus.curation.places.ground import Ground
from aeroscene.scene import Scene, SceneObject
from aeroscene.scene.catalogue import CATALOGUE, by_name
from aeroscene.solids.shapes import scene_primitives
from aeroscene.solids.solids import colliding
from aeroscene.validation.boxes import overlaps
from aeroscene.validation.support import floating

PLACES = {
    kind.make.__name__: kind.make for kind in themes.KINDS.values() if isinstance(kind.make, type)
}
KINDS = tuple(sorted(PLACES))
FURNISHED = ("Depot", "Houses", "School")
"""Kinds that can be asked for an interior; offices always have one."""
SIZES = ((14, 12), (24, 20), (42, 30))
"""Width and depth of small, usual and large parcels, m."""

Case = tuple[str, tuple[int, int], int, bool]
CASES: list[Case] = [
    *((kind, size, seed, False) for kind in KINDS for seed, size in enumerate(SIZES)),
    *((kind, size, seed, True) for kind in FURNISHED for seed, size in enumerate(SIZES)),
]
NAMES = [
    f"{kind}-{size[0]}x{size[1]}{'-furnished' * is_furnished}"
    for kind, size, _, is_furnished in CASES
]


@cache
def grown(case: Case) -> Scene:
    """All that a kind of place puts on a parcel of a turned street."""
    kind, (width, depth), seed, is_furnished = case
    builder = Builder("corpus-0000")
    parcel = Parcel(parcel_frame(depth), width, depth)
    ground = Ground(builder, Draw(np.random.default_rng(seed)), parcel)
    options = {"is_furnished": True} if is_furnished else {}
    place = PLACES[kind](ground, **options)
    for _ in place.structures():
        pass
    for _ in place.details():
        pass
    return scene_of(builder)


def parcel_frame(depth: float) -> Frame:
    return Frame(0.0, 0.0, 0.4).moved(0.0, -depth / 2)


def scene_of(builder: Builder) -> Scene:
    return Scene(
        scene_id=builder.scene_id,
        domain="outdoor",
        seed=0,
        extent_min_enu_m=(-60.0, -60.0, 0.0),
        extent_max_enu_m=(60.0, 60.0, 40.0),
        start_position_enu_m=(0.0, -55.0, 0.0),
        start_yaw_rad=0.0,
        latitude_deg=47.0,
        longitude_deg=8.0,
        altitude_m=0.0,
        objects=tuple(builder.objects),
    )


@pytest.fixture(params=CASES, ids=NAMES)
def case(request: pytest.FixtureRequest) -> Case:
    """One kind of place on one size of parcel."""
    return request.param


def of(scene: Scene, category: str) -> list[SceneObject]:
    return [obj for obj in scene.objects if obj.category == category]


def test_boxes_overlap_only_along_the_hierarchy(case):
    assert list(overlaps(grown(case))) == []


def test_nothing_floats(case):
    scene = grown(case)
    assert list(floating(scene, colliding(scene_primitives(scene)))) == []


def test_nothing_leaves_the_parcel(case):
    width, depth = case[1]
    frame = parcel_frame(depth)
    for obj in grown(case).objects:
        for x, y, z in obj.bbox.corners():
            u, v = frame.local(x, y)
            assert abs(u) <= width / 2 + 0.01, obj
            assert -0.01 <= v <= depth + 0.01, obj
            assert z >= -1e-9, obj


def test_sizes_are_real(case):
    for obj in grown(case).objects:
        category = by_name()[obj.category]
        spans = (category.length_m, category.width_m, category.height_m)
        for extent, (low, high) in zip(obj.bbox.s, spans, strict=True):
            assert 0.7 * low <= extent <= 1.3 * high, obj


def test_fine_objects_belong_to_what_carries_or_shelters_them(case):
    scene = grown(case)
    for obj in scene.objects:
        if not obj.is_coarse:
            assert obj.parent_id is not None, obj


@pytest.mark.parametrize("kind", KINDS)
def test_the_same_seed_gives_the_same_objects_and_another_seed_others(kind):
    first, again, other = (grown.__wrapped__((kind, (24, 20), s, False)) for s in (5, 5, 6))
    assert first.objects == again.objects
    assert first.objects != other.objects


@pytest.mark.parametrize("kind", KINDS)
def test_a_larger_parcel_holds_more(kind):
    small, usual, large = (
        len(grown((kind, size, seed, False)).objects) for seed, size in enumerate(SIZES)
    )
    assert 8 <= small <= usual <= large


@pytest.mark.parametrize("kind", KINDS)
def test_a_usual_parcel_offers_enough_in_small_steps(kind):
    builder = Builder("corpus-0000")
    ground = Ground(builder, Draw(np.random.default_rng(3)), Parcel(Frame(0, 0, 0), 26, 24))
    place = PLACES[kind](ground)
    counts = [0, *(builder.n_coarse for _ in place.structures())]
    assert builder.n_fine == 0
    assert 1 <= counts[1] <= (20 if kind == "Offices" else 6)
    assert max(np.diff(counts[1:]), default=0) <= 4
    assert counts[-1] >= 5
    counts = [0, *(builder.n_fine for _ in place.details())]
    # The rooms of a building that is entered are furnished at once.
    assert max(np.diff(counts)) <= (60 if kind == "Offices" else 10)
    assert np.mean(np.diff(counts)) <= 4
    assert counts[-1] >= 20


def test_every_outdoor_category_of_parcels_appears():
    seen = Counter(obj.category for case in CASES for obj in grown(case).objects)
    streets = {"road", "traffic_light", "bridge"}
    outdoors = {"ground", "roof", "building", "water"}
    wanted = {c.name for c in CATALOGUE.values() if outdoors & set(c.supports)} - streets
    assert wanted - set(seen) == set()


def test_cars_stand_square_to_their_bays_and_boats_along_what_they_are_moored_to():
    lot = grown(("Parking", (42, 30), 2, False))
    for car in of(lot, "car"):
        assert abs(cos(2 * (car.bbox.yaw_rad - 0.4 - pi / 2))) > 0.999 or car.parent_id == 0
    for boat in of(grown(("Waterfront", (42, 30), 2, False)), "boat"):
        assert abs(cos(2 * (boat.bbox.yaw_rad - 0.4))) > 0.999
        assert boat.parent_id is not None


def test_chairs_at_tables_face_them():
    scene = grown(("Market", (24, 20), 1, False))
    tables = np.array([table.bbox.p[:2] for table in of(scene, "table")])
    chairs = of(scene, "chair")
    assert chairs
    for chair in chairs:
        offsets = tables - chair.bbox.p[:2]
        nearest = offsets[np.argmin(np.hypot(*offsets.T))]
        heading = np.array([np.cos(chair.bbox.yaw_rad), np.sin(chair.bbox.yaw_rad)])
        assert heading @ nearest > 0.5 * np.hypot(*nearest)


def test_a_furnished_place_has_rooms_with_furniture():
    for kind in FURNISHED:
        scene = grown((kind, (42, 30), 2, True))
        rooms = {room.id for room in of(scene, "room")}
        assert rooms
        assert sum(obj.parent_id in rooms for obj in scene.objects) >= 6


def test_places_stand_as_well_on_raised_ground_and_on_a_slope():
    for kind in ("Houses", "Park", "Flats"):
        builder = Builder("corpus-0000")
        parcel = Parcel(Frame(0, 0, 0), 26, 24, level=0.0, rise=1.6)
        place = PLACES[kind](Ground(builder, Draw(np.random.default_rng(1)), parcel))
        for growth in (place.structures(), place.details()):
            for _ in growth:
                pass
        scene = scene_of(builder)
        assert len(scene.objects) >= 10
        assert list(overlaps(scene)) == []
        assert list(floating(scene, colliding(scene_primitives(scene)))) == []
