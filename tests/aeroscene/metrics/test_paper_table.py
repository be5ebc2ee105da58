"""The paper's table: its own figures, and ours in the same rows."""

import pytest

from aeroscene.corpus.dataset import SceneEntry
from aeroscene.metrics.paper_table import INCONSISTENCIES, missing_categories, paper_table
from aeroscene.scene.catalogue import CATALOGUE

ALL = [category.name for category in CATALOGUE.values()]


def entry(index, split="train", **counts):
    known = {"n_coarse": 34, "n_fine": 115, "n_small": 42, "n_medium": 11, "n_large": 5} | counts
    return SceneEntry(
        index=index,
        scene_id=f"corpus-{index:04d}",
        file=f"scenes/corpus-{index:04d}.json.gz",
        sha256="",
        sources="",
        split=split,
        domain="mixed",
        n_objects=known["n_coarse"] + known["n_fine"],
        n_perching=3,
        **known,
    )


def table(entries, names=ALL):
    return {row.key: row for row in paper_table(entries, {e.index: names for e in entries})}


def test_averages_are_those_of_the_scenes_of_each_split():
    rows = table([entry(0, "test", n_fine=100), entry(1), entry(2, n_fine=121)])
    fine = rows["fine_per_scene"]
    assert fine.ours == {"train": 118.0, "test": 100.0, "total": 112.0}
    assert fine.deviation == 0.0
    assert rows["scenes"].ours["total"] == 3
    assert rows["objects"].ours["total"] == 3 * 34 + 336
    assert rows["landing_areas_per_scene"].ours["total"] == 58


@pytest.mark.parametrize(("n_small", "is_met"), [(42, True), (40, True), (44, True), (39, False)])
def test_five_percent_off_is_still_met(n_small, is_met):
    assert table([entry(1, n_small=n_small)])["small_areas_per_scene"].is_met is is_met


def test_a_split_without_scenes_has_no_value():
    row = table([entry(1)])["objects_per_scene"].to_plain()
    assert row["value"] == 149
    assert row["paper"] == 149
    assert row["test"] == {"value": None, "paper": 152}


def test_categories_are_counted_over_all_scenes_of_a_split():
    entries = [entry(0, "test"), entry(1)]
    rows = paper_table(entries, {0: ["car", "tree"], 1: ["car", "house"]})
    by_key = {row.key: row.ours for row in rows}
    assert by_key["fine_categories"] == {"train": 1, "test": 2, "total": 2}
    assert by_key["coarse_categories"] == {"train": 1, "test": 0, "total": 1}
    assert table([entry(1)])["fine_categories"].is_met
    assert missing_categories(ALL[:-2]) == ALL[-2:]


def test_the_paper_contradicts_itself_as_we_say():
    paper = {row.key: row.paper for row in table([entry(1)]).values()}
    objects, scenes = paper["objects"], paper["scenes"]
    said = " ".join(INCONSISTENCIES)
    for column, figure in (("total", 157), ("train", 151), ("test", 185)):
        assert round(objects[column] / scenes[column]) == figure
        assert str(figure) in said
    sizes = sum(paper[f"{size}_areas_per_scene"]["total"] for size in ("small", "medium", "large"))
    assert sizes == 59 != paper["landing_areas_per_scene"]["total"]
    assert paper["coarse_per_scene"]["total"] + paper["fine_per_scene"]["total"] == 146
