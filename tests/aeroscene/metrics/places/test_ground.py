import pytest

from aeroscene.metrics.places.ground import covered_shares, patches, remote_parking
from aeroscene.metrics.places.top_view import TopView
from tests.aeroscene.metrics.scenes import box, scene_of

ROAD = ("road", box((0, 0, 0.02), (40, 6, 0.04)))


def piece(category, x, y, size_x, size_y, *parent):
    return (category, box((x, y, 0.05), (size_x, size_y, 0.1)), *parent)


def n_patches(*rows):
    return patches(TopView(scene_of(*rows))).tolist()


@pytest.mark.parametrize("category", ["road", "sidewalk", "plaza", "parking_lot"])
@pytest.mark.parametrize(("gap_m", "count"), [(0.0, 1), (0.25, 1), (0.35, 2)])
def test_a_gap_parts_two_patches(category, gap_m, count):
    assert n_patches(ROAD, piece(category, 0, 5 + gap_m, 10, 4)) == [count]


def test_a_chain_of_pieces_is_one_patch():
    walk = piece("sidewalk", 0, 4, 40, 2)
    plaza = piece("plaza", 0, 10, 10, 10)
    assert n_patches(ROAD, walk, plaza) == [1]
    assert n_patches(ROAD, plaza) == [2]


def test_lawns_join_nothing_and_scenes_without_paving_are_not_judged():
    lawn = piece("lawn", 0, 8, 40, 10)
    assert n_patches(ROAD, lawn, piece("plaza", 0, 20, 10, 10)) == [2]
    assert n_patches(lawn) == n_patches() == []


def test_what_lies_in_a_building_is_no_part_of_the_site():
    house = ("building", box((0, 30, 2), (10, 10, 4)))
    inside = piece("plaza", 0, 30, 5, 5, 1)
    assert n_patches(ROAD, house, inside) == [1]
    assert covered(house, piece("lawn", 0, 30, 4, 4, 0)) == []


def covered(*rows):
    return covered_shares(TopView(scene_of(*rows))).tolist()


def test_a_site_without_a_gap_is_covered_and_one_with_a_gap_is_not():
    assert covered(ROAD, piece("lawn", 0, 13, 40, 20)) == pytest.approx([1.0])
    # A strip of 4 m of 30 m is bare.
    assert covered(ROAD, piece("lawn", 0, 17, 40, 20)) == pytest.approx([26 / 30])


def test_a_bare_corner_counts_as_far_as_the_hull_reaches():
    # The hull cuts the corner of 20 m by 10 m that is bare in half.
    corner = [piece("lawn", 0, 0, 40, 10), piece("lawn", -10, 10, 20, 10)]
    assert covered(*corner) == pytest.approx([600 / 700])


def test_a_building_covers_the_ground_it_stands_on():
    lawns = [piece("lawn", x, 0, 10, 10) for x in (-10, 10)]
    assert covered(*lawns) == pytest.approx([2 / 3])
    assert covered(*lawns, ("house", box((0, 0, 2), (10, 10, 4)))) == pytest.approx([1.0])


@pytest.mark.parametrize("way", ["road", "sidewalk", "plaza"])
def test_a_parking_lot_lies_on_a_way(way):
    for gap_m, is_remote in ((0.0, False), (1.4, False), (1.6, True)):
        rows = (piece(way, 0, 0, 40, 6), piece("parking_lot", 0, 8 + gap_m, 10, 10))
        assert remote_parking(TopView(scene_of(*rows))).tolist() == [is_remote]


def test_without_any_way_every_lot_is_remote():
    rows = (piece("parking_lot", 0, 0, 10, 10), piece("lawn", 0, 10, 10, 10))
    assert remote_parking(TopView(scene_of(*rows))).tolist() == [True]
