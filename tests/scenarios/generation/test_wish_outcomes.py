"""What was got stands beside what was asked for, and is judged by the tolerance that help names."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from aeroscene.corpus.shipped import read_shipped
from aeroscene.learning.generation import AreaCounts, Request
from scenarios.cli.generate_words import _missed, _print_wishes
from scenarios.generation.wish_outcomes import WishOutcome, beside_wishes, unmet, with_measures


@pytest.fixture(scope="module")
def park():
    return read_shipped(40)


def got(scene, *, wish=None, **asked):
    """The wishes of a draw that gave this scene."""
    measured = asked.pop("measured", {})
    request = Request(seed=1, **asked)
    scene = replace(scene, wishes=request.wishes | asked.pop("more", {}), measured=measured)
    found = SimpleNamespace(request=request, raw=scene, wish=wish)
    return beside_wishes(found, scene)


def test_objects_may_be_missed_by_a_fifth(park):
    n = len(park.objects)
    for asked, ok in ((n, True), (round(n / 1.19), True), (round(n / 0.7), False)):
        found = got(park, n_objects=asked)
        assert found["objects"].to_plain() == {"asked": asked, "got": n, "met": ok}


def test_each_side_of_the_outline_may_be_missed_by_a_tenth(park):
    low, high = park.extent_min_enu_m, park.extent_max_enu_m
    east_m, north_m = high[0] - low[0], high[1] - low[1]
    assert got(park, outline_m=(1.05 * east_m, 0.95 * north_m))["outline"].is_met
    missed = got(park, outline_m=(east_m, 0.8 * north_m))["outline"]
    assert not missed.is_met
    assert missed.measured == f"{east_m:.1f},{north_m:.1f}"


def test_areas_are_bounded_from_above_and_themes_are_compared(park):
    n = len(park.landing_areas)
    found = got(park, n_areas=n, theme="office")
    assert (found["areas"].measured, found["areas"].is_met) == (n, True)
    assert not found["theme"].is_met
    n_small = sum(area.drone_class == "small" for area in park.landing_areas)
    few = got(park, n_areas=AreaCounts(small=max(0, n_small - 1), large=200))
    assert few["areas_small"].is_met is (n_small == 0)
    assert few["areas_large"].is_met
    assert set(few) == {"areas_small", "areas_large"}


def test_density_and_clutter_are_the_factors_that_have_come_out(park):
    n_fine = sum(not obj.is_coarse for obj in park.objects)
    # Told to draw twice the usual number, the model drew half of that.
    found = got(park, density=2.0, wish=SimpleNamespace(n_fine=2 * n_fine))["density"]
    assert (found.measured, found.is_met) == (1.0, False)
    found = got(park, density=0.5, wish=SimpleNamespace(n_fine=n_fine))["density"]
    assert (found.measured, found.is_met) == (0.5, True)
    # Nothing was added to what had been drawn.
    found = got(park, clutter=3.0)["clutter"]
    assert (found.measured, found.is_met) == (1.0, False)


def test_passages_that_are_measured_are_compared(park):
    for width_m, ok in ((1.2, True), (1.195, True), (1.1, False)):
        found = got(park, min_passage_m=1.2, measured={"min_passage": width_m})["min_passage"]
        assert (found.measured, found.is_met) == (width_m, ok)
    assert got(park, min_passage_m=1.2)["min_passage"].is_met


def test_a_scene_without_wishes_has_nothing_beside_them(park):
    assert got(park) == {}
    assert with_measures(park, {}).measured == park.measured


def test_the_document_and_the_terminal_tell_what_was_got(park, capsys):
    n = len(park.objects)
    found = got(park, n_objects=20, theme=park.theme)
    assert with_measures(park, found).measured == {"theme": park.theme, "objects": n}
    assert unmet(found) == f"objects {n} where 20 was asked for"
    files = {"out/a.json": found, "out/b.json": got(park, n_objects=n, theme=park.theme)}
    assert _missed(files) == ["out/a.json"]
    _print_wishes(files)
    text = " ".join(capsys.readouterr().out.split())
    assert f"asked for │ {park.theme} │ 20 │" in text
    assert f"a.json │ {park.theme} │ {n} * │" in text
    assert f"b.json │ {park.theme} │ {n} │" in text
    assert text.endswith("* 1 of 2 scenes are not as asked for; --strict draws those again")


def test_many_wishes_have_a_row_each(park, capsys):
    n = len(park.objects)
    met = got(park, n_objects=n, theme=park.theme)
    missed = got(park, n_objects=20, theme=park.theme)
    more = {f"thing {k}": WishOutcome("at least 3", k, k >= 3) for k in range(5)}
    _print_wishes({f"out/aeroscene-000{k}.json": (missed if k else met) | more for k in range(5)})
    text = " ".join(capsys.readouterr().out.split())
    assert "┃ asked for ┃ aeroscene-0000 ┃ aeroscene-0001 ┃ met in ┃" in text
    assert f"objects │ {n} │ {n} │ {n} * │ 1 of 5" in text
    assert "thing 2 │ at least 3 │ 2 * │ 2 * │ 0 of 5" in text
    assert "and 3 more; --json lists them" in text
