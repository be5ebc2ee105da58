"""A leaderboard has an entry for each stack that flew a whole fixed suite."""

import json
from dataclasses import fields, replace
from pathlib import Path

import pytest

from aeroscene.corpus.shipped import shipped_digest
from scenarios.campaigns.fixed import FixedSuiteError, fixed_suite, fixed_suites, suite
from scenarios.reports import leaderboard
from scenarios.reports.leaderboard import LeaderboardError, update_leaderboard
from scenarios.tasks.recipe import Recipe
from tests.scenarios.in_process import in_process
from tests.scenarios.reports.campaigns import campaign, change_manifest, row, trials

WHOLE = fixed_suite("aeroscene-300")
PART = replace(WHOLE.parts[0], scenes=("0", "5"), vehicles=("iris",), trials=2)
SMALL = replace(WHOLE, parts=(PART,))


@pytest.fixture(autouse=True)
def small(monkeypatch):
    monkeypatch.setattr(leaderboard, "fixed_suites", lambda: [SMALL])


def flown(folder, successes, **more):
    rows = [row(trial, good) for trial, good in zip(SMALL.all_trials(), successes, strict=False)]
    return campaign(folder, [*rows, row(trials(1, "9")[0], False)], recipe=SMALL.recipe, **more)


def test_suites_are_of_the_shipped_scenes_and_their_trials_have_names_of_their_own():
    for each in fixed_suites():
        assert each.scenes_sha256 == shipped_digest()
        names = [trial.id for trial in each.all_trials()]
        assert (
            len(names)
            == len(set(names))
            == sum(len(part.scenes) * len(part.vehicles) * part.trials for part in each.parts)
        )
    assert len(WHOLE.all_trials()) == 300 * len(WHOLE.parts[0].scenes)


def test_a_suite_with_a_recipe_names_each_of_its_fields():
    """TOML has no word for none, so a field that is none by default is left out."""
    text = Path(suite.__file__).with_name("aeroscene-300.toml").read_text()
    lines = {line.partition(" =")[0] for line in text.splitlines()}
    assert {field.name for field in fields(Recipe) if field.default is not None} <= lines


def test_other_scenes_are_refused(monkeypatch, capsys, tmp_path):
    monkeypatch.setattr(suite, "shipped_digest", lambda: "f" * 64)
    with pytest.raises(FixedSuiteError, match=r"these are ffffffffffff; valid: the release"):
        fixed_suite("aeroscene-300")
    options = ("campaign", "--out", tmp_path / "out", "--suite")
    status, _, err = in_process(capsys, *options, "aeroscene-300")
    assert (status, err.count("\n")) == (2, 1)
    monkeypatch.undo()
    for more, says in (
        (("none",), "suite 'none' is unknown; valid: aeroscene-300"),
        (("aeroscene-300", "--trials", "3"), "trials is fixed by suite 'aeroscene-300'"),
    ):
        status, _, err = in_process(capsys, *options, *more)
        assert (status, err.count("\n")) == (2, 1)
        assert says in err
    assert not (tmp_path / "out").exists()


def test_entries_are_added_replaced_and_ranked(tmp_path):
    path = tmp_path / "board.json"
    ours = flown(tmp_path / "ours", [True, True, True, False])
    update_leaderboard(path, flown(tmp_path / "line", [True, False, False, False]), "a|line")
    entry = update_leaderboard(path, ours)
    assert update_leaderboard(path, ours) == entry
    entries = json.loads(path.read_text())["entries"]
    assert [each["stack"] for each in entries] == ["demo", "a|line"]
    # The failure in a scene that is not of the suite counts nowhere.
    assert (entry["trials"], entry["successes"], entry["success_rate"]) == (4, 3, 0.75)
    assert entry["medians"]["navigation_s over least_navigation_s"] == 4.0
    lines = path.with_suffix(".md").read_text().splitlines()
    assert len({line.replace("\\|", "").count("|") for line in lines}) == 1
    assert lines[2].startswith(f"| aeroscene-300 {SMALL.version} | demo | ")
    assert "a\\|line" in lines[3]


def test_parts_of_a_suite_other_recipes_and_other_files_are_refused(tmp_path):
    path = tmp_path / "board.json"
    part = flown(tmp_path / "part", [True, True, True])
    with pytest.raises(LeaderboardError, match=r"lacks 1 of the 4 trials of aeroscene-300; valid"):
        update_leaderboard(path, part)
    other = campaign(tmp_path / "other", [], recipe=Recipe(seed=1))
    with pytest.raises(LeaderboardError, match="another recipe or other scenes"):
        update_leaderboard(path, other)
    change_manifest(part, scenes_sha256="0" * 64)
    with pytest.raises(LeaderboardError, match="another recipe or other scenes"):
        update_leaderboard(path, part)
    assert not path.exists()
    path.write_text("{}")
    with pytest.raises(LeaderboardError, match="is none; valid"):
        update_leaderboard(path, part)
    with pytest.raises(LeaderboardError, match=r"is no .json file; valid: NAME.json"):
        update_leaderboard(tmp_path / "board.csv", part)


def test_report_refuses_in_one_line(tmp_path, capsys):
    part = flown(tmp_path / "part", [True])
    status, out, err = in_process(capsys, "report", part, "--leaderboard", tmp_path / "b.json")
    assert (status, out, err.count("\n")) == (2, "", 1)
    assert "lacks 3 of the 4 trials" in err
