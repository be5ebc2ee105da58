"""The model that ships, at work."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from aeroscene.corpus.shipped import read_shipped
from aeroscene.feasibility import validity
from aeroscene.learning.diffusion.sampling import Moment
from aeroscene.learning.generation import Generated, Generator, Request, RequestError
from aeroscene.learning.generation import generator as generation
from aeroscene.learning.generation.proposal import Proposal
from aeroscene.learning.generation.sense import senseless
from aeroscene.learning.training.checkpoint_facts import CheckpointError
from aeroscene.learning.training.devices import DeviceError
from aeroscene.scene import OrientedBox, Scene
from aeroscene.scene.catalogue import COVERS
from aeroscene.scene.io import scene_to_json
from aeroscene.validation import validate
from tests.aeroscene.conftest import cached_scene
from tests.aeroscene.metrics.scenes import box, scene_of
from tests.thorough import THOROUGH


@pytest.fixture(scope="module")
def generator() -> Generator:
    return Generator.load(device="cpu", n_steps=12)


@pytest.fixture(scope="module")
def generated(generator: Generator) -> list[Generated]:
    """One scene of each domain."""
    domains = ("mixed", "outdoor", "indoor")
    requests = [Request(seed=5 + i, domain=domain) for i, domain in enumerate(domains)]
    return list(generator.generate(requests))


def test_scenes_are_sound_and_can_be_flown(generated: list[Generated]) -> None:
    for each in generated:
        assert each.scene is not None, each.report.rejection
        assert each.scene.domain == each.request.domain
        assert validate(each.scene) == ()
        assert len(each.scene.landing_areas) > 5


def test_most_objects_are_right_before_the_projection(generated: list[Generated]) -> None:
    shares = [validity(each.raw).is_valid.mean() for each in generated]
    assert sum(shares) / len(shares) > 0.8
    assert all(validity(each.projected).is_valid.mean() > 0.98 for each in generated)


def test_same_request_gives_the_same_scene(
    generator: Generator, generated: list[Generated]
) -> None:
    again = next(generator.generate([generated[2].request]))
    assert scene_to_json(again.projected) == scene_to_json(generated[2].projected)
    assert scene_to_json(generator.sampled(again.request)) == scene_to_json(again.raw)
    other = generator.sampled(replace(again.request, seed=77))
    assert scene_to_json(other) != scene_to_json(again.raw)


def test_site_has_the_outline_that_was_asked_for(generator: Generator) -> None:
    # A yard's ground is divided without gaps; a street that winds may leave the outline in part.
    request = Request(seed=5, theme="industrial_yard", domain="outdoor", outline_m=(62.0, 84.0))
    raw = generator.sampled(request)
    covers = [obj.bbox.corners() for obj in raw.objects if obj.category in COVERS]
    most = np.concatenate(covers)[:, :2].max(axis=0)
    assert most == pytest.approx([31.0, 42.0], abs=0.02)


def test_places_are_what_was_asked_for(generator: Generator) -> None:
    request = Request(seed=5, theme="waterfront", domain="outdoor")
    (made,) = generator.generate([request])
    assert made.projected.theme == "waterfront"
    assert any(obj.category == "water" for obj in made.projected.objects)


def test_every_scene_has_a_start_pad(generator: Generator) -> None:
    """At each single place a pad is seldom, so a third of all scenes went without."""
    domains = ("mixed", "outdoor")
    for seed in range(8):
        scene = generator.sampled(Request(seed=seed, domain=domains[seed % 2]))
        pads = [obj for obj in scene.objects if obj.attributes.get("is_start") is True]
        assert [obj.category for obj in pads] == ["landing_pad"]


def test_completion_keeps_coarse_objects_where_they_are(generator: Generator) -> None:
    given = cached_scene(311)
    raw = generator.sampled(Request(seed=6, complete=given))
    assert _coarse(raw) == _coarse(given)
    assert sum(not obj.is_coarse for obj in raw.objects) > 20


def _coarse(scene: Scene) -> list[tuple]:
    coarse = (obj for obj in scene.objects if obj.is_coarse)
    return sorted((obj.category, obj.bbox.p, *sorted(obj.attributes.items())) for obj in coarse)


@pytest.mark.parametrize(
    "number", [0, 27, 794, *(pytest.param(each, marks=THOROUGH) for each in (4, 20, 160))]
)
def test_what_the_model_made_can_be_completed_by_it(generator: Generator, number: int) -> None:
    """Each has an object of a kind that the corpus lacks, or of the last three no whole partition.

    Walls that meet by more than a partition may have, a road that turns at once, two rooms that
    share a hand's breadth.
    """
    given = read_shipped(number)
    made = generator.sound_scene(Request(seed=42, complete=given))
    assert _coarse(made.raw) == _coarse(given)
    if number != 794:  # Its rooms overlap, which the projection mends.
        assert _coarse(made.projected) == _coarse(given)
    assert made.raw.extent_max_enu_m == given.extent_max_enu_m
    by_id = made.raw.object_by_id
    for obj in made.raw.objects:
        if not obj.is_coarse and obj.parent_id is not None:
            rise_m = obj.bbox.p[2] - by_id[obj.parent_id].bbox.p[2]
            assert abs(rise_m) < by_id[obj.parent_id].bbox.s[2] + 6.0


def test_onlooker_sees_every_step_from_noise_to_layout(generator: Generator) -> None:
    times: list[float] = []

    def look(moment: Moment, proposals: Sequence[Proposal]) -> None:
        times.append(moment.time)
        assert len(proposals) == 1

    next(generator.generate([Request(seed=0, domain="indoor")], on_step=look))
    assert len(times) == 12
    assert times[0] == 1.0
    assert times == sorted(times, reverse=True)


@pytest.mark.parametrize("preset", ["paper", "progressive"])
def test_the_papers_models_lay_out_about_as_many_objects_within_their_training(preset) -> None:
    """How good they are on so little training, docs/notebook.md says."""
    paper = Generator.load(preset=preset, device="cpu", n_steps=25)
    request = Request(seed=1, n_objects=100)
    made = paper.sampled(request)
    assert len(made.objects) == pytest.approx(100, rel=0.4)
    assert len({obj.category for obj in made.objects}) > 10
    places = np.array([obj.bbox.p for obj in made.objects])
    assert (np.abs(places[:, :2]) < 60.0).all()
    assert scene_to_json(paper.sampled(request)) == scene_to_json(made)
    with pytest.raises(RequestError, match="an outline or a scene is given"):
        next(paper.generate([Request(seed=1, outline_m=(50.0, 50.0))]))
    with pytest.raises(RequestError, match="theme is 'park'; valid: no theme; the model knows"):
        next(paper.generate([Request(seed=1, theme="park")]))


def test_missing_checkpoint_or_device_or_preset_says_what_is_valid() -> None:
    with pytest.raises(CheckpointError, match="cannot be read"):
        Generator.load("nowhere.safetensors", device="cpu")
    with pytest.raises(CheckpointError, match="preset is 'better'; valid: default, paper"):
        Generator.load(preset="better", device="cpu")
    with pytest.raises(DeviceError, match="device 'cuda:9' is not there"):
        Generator.load(device="cuda:9")


def with_pad(*things: tuple[str, OrientedBox]) -> Scene:
    """A scene of these objects and a pad to start from."""
    scene = scene_of(*things, ("landing_pad", box((0, -8, 0.1), (2.6, 2.6, 0.05))))
    *others, pad = scene.objects
    return replace(scene, objects=(*others, replace(pad, attributes={"is_start": True})))


def test_a_draw_with_a_lot_that_nothing_leads_to_is_drawn_again(
    generator: Generator, monkeypatch: pytest.MonkeyPatch
) -> None:
    lot = ("parking_lot", box((0, 0, 0.02), (8, 6, 0.04)))
    road, away = (("road", box((0, y_m, 0.02), (20, 6, 0.04))) for y_m in (6, 30))
    bridge = ("bridge", box((0, 6, 2), (4, 12, 4)))
    assert senseless(with_pad(lot, road, bridge)) is None
    assert senseless(with_pad(lot, away)) == "a parking lot is off every road, sidewalk and plaza"
    assert senseless(with_pad(away, bridge)) == "a bridge is over neither water nor road"
    assert senseless(scene_of(lot, road, bridge)) == "there is no pad to start from"
    reasons = iter(["no place", None])
    monkeypatch.setattr(generation, "senseless", lambda _: next(reasons))
    assert generator.sound_scene(Request(seed=5, n_objects=40)).attempt == 1
