"""What `aeroscene bench generate` says of scenes, told by corpus scenes that were disturbed."""

import math
from dataclasses import replace

import numpy as np
import pytest

from aeroscene.metrics.comparison import Reference, figures_of
from aeroscene.metrics.damage import jittered
from aeroscene.metrics.places.checks import CHECKS
from scenarios.bench.quality import (
    FEASIBLE,
    RAW,
    TEST,
    TRAIN,
    Drawn,
    comparison,
    feasibility_rows,
    statistics_rows,
    validity_rows,
)
from scenarios.bench.soundness import fault
from scenarios.cli.main import main
from tests.aeroscene.conftest import sampled_scenes


def by_metric(rows):
    return {row.metric: row for row in rows}


def disturbed(spread_m):
    rng = np.random.default_rng(0)
    return [jittered(scene, rng, spread_m=spread_m) for scene in sampled_scenes()]


@pytest.fixture(scope="module")
def figures():
    rng = np.random.default_rng(0)
    reference = Reference.measure(sampled_scenes(), sampled_scenes())
    groups = {
        RAW: disturbed(0.5),
        FEASIBLE: disturbed(0.05),
        TEST: sampled_scenes(),
        TRAIN: sampled_scenes(),
    }
    return {name: figures_of(scenes, reference, rng) for name, scenes in groups.items()}


def test_after_feasibility_collisions_are_held_to_those_of_the_test_split(figures):
    rows = by_metric(comparison(figures))
    for name in ("collision rate, all pairs", "objects over 1 cm deep in a stranger"):
        before, after, truth = (rows[f"{name}, {group}"] for group in (RAW, FEASIBLE, TEST))
        assert before.target is truth.target is None
        assert after.target == truth.value < after.value < before.value
        assert not after.is_met


def test_distances_are_held_to_the_test_split_and_mmd_to_its_noise(figures):
    rows = by_metric(comparison(figures))
    name = "distance to the nearest training scene, median"
    assert rows[f"{name}, {FEASIBLE}"].target == 0.9 * rows[f"{name}, {TEST}"].value
    assert rows[f"{name}, {FEASIBLE}"].better == "higher"
    noise = 1e3 * figures[RAW].discrepancy.noise
    mmd = rows[f"layout MMD, {FEASIBLE}"]
    assert mmd.target == pytest.approx(rows[f"layout MMD, {RAW}"].value + noise)
    assert (mmd.better, mmd.is_met) == ("lower", True)


def test_places_plausibility_and_the_classifier_are_held_to_goals_of_their_own(figures):
    rows = by_metric(comparison(figures))
    for check in CHECKS:
        for group in (RAW, FEASIBLE, TEST):
            row = rows.get(f"{check.title}, {group}")
            assert (row is None) == math.isnan(figures[group].places[check.key])
            if row is not None:
                assert row.target == (check.goal if group == FEASIBLE else None)
                assert row.better == check.better
    # Half a metre off their places, chairs no longer face their tables nor do walls meet.
    for key in ("averted_chairs", "loose_wall_ends"):
        before, truth = figures[RAW].places[key], figures[TEST].places[key]
        assert before > truth + 3.0
    assert rows[f"semantic plausibility, {FEASIBLE}"].target == 6.65
    assert rows[f"real-or-generated classifier's accuracy, {FEASIBLE}"].target == 65.0


def test_where_nothing_is_judged_there_is_no_row(figures):
    rows = by_metric(comparison(figures))
    # None of these scenes has a bridge.
    assert not any(metric.startswith("bridges") for metric in rows)
    assert all(math.isfinite(row.value) for row in rows.values())


def test_a_model_without_feasible_scenes_is_compared_as_far_as_it_came(figures):
    rows = by_metric(comparison({name: figures[name] for name in (RAW, TEST, TRAIN)}))
    assert f"layout MMD, {RAW}" in rows
    assert not any(metric.endswith(FEASIBLE) for metric in rows)


def test_corpus_scenes_are_valid_and_jittered_ones_are_not():
    real = by_metric(validity_rows(sampled_scenes(), TEST, None))
    raw = by_metric(validity_rows(disturbed(0.5), RAW, 85.0))
    assert real[f"objects valid, {TEST}"].value > 99.0
    assert not raw[f"objects valid, {RAW}"].is_met
    assert raw[f"objects valid, {RAW}"].value <= raw[f"objects free of others, {RAW}"].value


def test_soundness_displacement_and_losses_are_over_all_draws():
    kept, lost = sampled_scenes()[0], sampled_scenes()[1]
    gone = lost.objects[-1].id
    lesser = replace(
        lost,
        objects=lost.objects[:-1],
        interaction_areas=tuple(a for a in lost.interaction_areas if a.object_id != gone),
    )
    bare = replace(sampled_scenes()[2], interaction_areas=())
    draws = [
        Drawn(raw=kept, projected=kept, is_rejected=False),
        Drawn(raw=lost, projected=lesser, is_rejected=False),
        Drawn(raw=sampled_scenes()[2], projected=bare, is_rejected=True),
    ]
    seen = []
    rows = by_metric(feasibility_rows(draws, lambda: seen.append(1)))
    assert len(seen) == 3
    assert rows["draws sound, after"].value == pytest.approx(200 / 3)
    assert rows["draws rejected"].value == pytest.approx(100 / 3)
    n_objects = sum(len(draw.raw.objects) for draw in draws)
    assert rows["objects dropped"].value == pytest.approx(100 / n_objects)
    assert rows["displacement, median"].value == 0.0


def test_what_keeps_a_scene_from_being_flown_is_said():
    scene = sampled_scenes()[0]
    assert fault(scene) is None
    assert "no landing area" in str(fault(replace(scene, interaction_areas=())))
    crowded = replace(disturbed(0.5)[0], interaction_areas=scene.interaction_areas)
    assert "valid" in str(fault(crowded))


def test_averages_stand_beside_the_papers():
    rows = by_metric(statistics_rows(sampled_scenes()))
    mean = np.mean([len(scene.objects) for scene in sampled_scenes()])
    assert rows["objects / scene, mean"].value == pytest.approx(mean)
    off = rows["objects / scene, off the paper's"]
    assert off.value == pytest.approx(100 * abs(mean / 149 - 1))
    assert (off.target, off.better) == (10.0, "lower")
    assert len(rows) == 14


@pytest.mark.parametrize(
    ("args", "says"),
    [
        (("--count", "1"), "count 1"),
        (("--seed", "-1"), "seed -1"),
        (("--preset", "huge"), "huge"),
        (("--data", "nowhere"), "'nowhere' holds no dataset"),
    ],
)
def test_bad_input_ends_with_status_2_and_one_line(args, says, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as stop:
        main(["bench", "generate", *args])
    assert stop.value.code == 2
    output = capsys.readouterr()
    assert output.out == ""
    (line,) = output.err.strip().splitlines()
    assert says in line
