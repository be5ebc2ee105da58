"""Draws of a seed until a prompt is met; where none does, the best one is kept."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import pytest

from aeroscene.corpus.shipped import read_shipped
from aeroscene.learning.generation import Request
from aeroscene.scene.io import read_scene
from scenarios.generation.draws import AnyScene, Tally, draw_all
from scenarios.generation.prompts.wishes import Count

MOST_DRAWS = 4
PROMPT = "a park with benches"


class Draws:
    """Gives scenes in turn, each for the seed that is asked for; None is an unsound draw."""

    def __init__(self, *scenes):
        self.scenes = list(scenes)

    def generate(self, requests, *, attempt, **_more):
        for request in requests:
            scene = self.scenes.pop(0)
            named = f"aeroscene-{request.seed:04d}"
            raw = read_shipped(40) if scene is None else scene
            if scene is not None:
                objects = tuple(replace(obj, scene_id=named) for obj in scene.objects)
                scene = replace(
                    scene, scene_id=named, seed=request.seed, objects=objects, wishes=request.wishes
                )
            report = SimpleNamespace(rejection=None if scene else "it floats")
            yield SimpleNamespace(
                request=request, raw=raw, scene=scene, report=report, wish=None, attempt=attempt
            )


@pytest.fixture(scope="module")
def park():
    return read_shipped(40)


def with_benches(scene, n):
    """The scene with only so many of its benches."""
    benches = [obj.id for obj in scene.objects if obj.category == "bench"][n:]
    objects = tuple(obj for obj in scene.objects if obj.id not in benches)
    areas = tuple(area for area in scene.interaction_areas if area.object_id not in benches)
    return replace(scene, objects=objects, interaction_areas=areas)


def drawn(out, *scenes, demands, is_strict=False, prompt=PROMPT):
    tally = Tally(out, is_strict=is_strict, prompt=prompt, demands=demands)
    draws = Draws(*scenes)
    request = Request(seed=7)
    judge = AnyScene(MOST_DRAWS)
    draw_all(cast("Any", draws), [request], judge, tally, batch_size=1, advance=lambda: None)
    return tally, draws


def test_a_seed_is_drawn_until_it_meets_the_prompt(park, tmp_path):
    scenes = [with_benches(park, n) for n in (1, 3, 2)]
    tally, draws = drawn(tmp_path, *scenes, demands=[Count("bench", 3, 3)])
    assert len(draws.scenes) == 1
    assert (tally.n_rejected, tally.failed) == (1, {})
    scene = read_scene(tmp_path / "aeroscene-0007.json")
    assert scene.wishes == {"prompt": PROMPT, "bench": "3"}
    assert scene.measured == {"bench": 3}


def test_the_best_draw_is_kept_where_none_meets_it(park, tmp_path):
    scenes = [with_benches(park, 1), with_benches(park, 3), None, with_benches(park, 2)]
    tally, draws = drawn(tmp_path, *scenes, demands=[Count("bench", 4), Count("boat", 1)])
    assert draws.scenes == []
    assert (tally.n_rejected, tally.failed) == (3, {})
    (wishes,) = tally.wishes.values()
    assert {name: wish.to_plain() for name, wish in wishes.items()} == {
        "bench": {"asked": "at least 4", "got": 3, "met": False},
        "boat": {"asked": "at least 1", "got": 0, "met": False},
    }
    assert read_scene(tmp_path / "aeroscene-0007.json").measured["bench"] == 3


def test_a_draw_that_meets_more_wishes_is_better_than_one_that_is_nearer(park, tmp_path):
    scenes = [with_benches(park, n) for n in (4, 3, 0, 0)]
    demands = [Count("bench", 5), Count("boat", 0, 0)]
    tally, _ = drawn(tmp_path, *scenes, demands=demands)
    assert next(iter(tally.wishes.values()))["bench"].measured == 4


def test_with_strict_a_seed_that_never_meets_it_is_named(park, tmp_path):
    scenes = [with_benches(park, n) for n in (1, 2, 1, 2)]
    tally, _ = drawn(tmp_path, *scenes, demands=[Count("bench", 4)], is_strict=True)
    assert tally.files == []
    assert "the last of 4 draws has bench 2 where at least 4 was asked for" in tally.failed[7]


def test_a_seed_whose_draws_are_all_unsound_is_named(tmp_path):
    tally, _ = drawn(tmp_path, *[None] * MOST_DRAWS, demands=[Count("bench", 4)])
    assert (tally.files, tally.failed) == ([], {7: "it floats"})


def test_without_a_prompt_the_first_sound_draw_is_kept(park, tmp_path):
    tally, draws = drawn(tmp_path, park, park, demands=(), prompt="")
    assert (len(tally.files), len(draws.scenes)) == (1, 1)
    assert read_scene(tally.files[0]).wishes == {}
