"""A small model with its first weights at work: what holds whatever it has learned."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import torch

from aeroscene.learning.diffusion.config import SamplerCfg
from aeroscene.learning.diffusion.schedule import Schedule
from aeroscene.learning.generation import Generator, Request, RequestError
from aeroscene.learning.generation.denoising import Denoising
from aeroscene.learning.generation.programs import ProgramProposer
from aeroscene.learning.model.config import ModelCfg
from aeroscene.learning.training.networks import new_denoiser
from aeroscene.learning.writer.config import WriterCfg
from aeroscene.learning.writer.examples import encodable
from aeroscene.learning.writer.language import Language, learn_language
from aeroscene.learning.writer.model import new_writer
from aeroscene.scene.io import scene_to_json
from tests.aeroscene.conftest import cached_scene

NUMBERS = (7, 42, 49, 311)
CPU = torch.device("cpu")


def small_generator(language: Language, wishes) -> Generator:
    torch.manual_seed(0)
    writer = new_writer(WriterCfg(width=16, kind_width=8, layers=1), language).eval()
    cfg = ModelCfg(n_kinds=len(language.vocabulary.kinds), width=16, blocks=2, heads=2)
    denoiser = new_denoiser(cfg, language, Schedule()).eval()
    denoising = Denoising(language, denoiser, Schedule(), SamplerCfg(n_steps=3), CPU)
    return Generator(ProgramProposer(language, writer, denoising), "cpu", wishes)


@pytest.fixture(scope="module")
def corpus():
    return encodable([cached_scene(number) for number in NUMBERS])


@pytest.fixture(scope="module")
def generator(corpus) -> Generator:
    return small_generator(learn_language(corpus[0]), corpus[1])


def raw(generator: Generator, *requests: Request, **more):
    """What is proposed, without the projection, which takes long for noise."""
    proposals = []
    for request in requests:
        streams = [np.random.default_rng((request.seed, k)) for k in range(3)]
        wish, _ = request.drawn(streams[0], generator._seen, generator._proposer.themes)
        (found,) = generator._proposer.propose([request], [wish], [streams[1]], **more)
        proposals.append(found.scene("scene", request.seed, streams[2]))
    return proposals


def test_same_seed_gives_the_same_scene_and_another_another(generator):
    first, again, other = raw(generator, *(Request(seed=seed) for seed in (3, 3, 4)))
    assert scene_to_json(first) == scene_to_json(again)
    assert scene_to_json(first) != scene_to_json(other)


@pytest.mark.parametrize("domain", ["outdoor", "mixed", "indoor"])
def test_site_or_building_has_the_sides_that_were_asked_for(generator, domain):
    outline_m = (48.0, 36.0)
    request = Request(seed=5, domain=domain, outline_m=outline_m)
    streams = [np.random.default_rng((5, k)) for k in range(2)]
    wish, _ = request.drawn(streams[0], generator._seen)
    (found,) = generator._proposer.propose([request], [wish], [streams[1]])
    program = found.program
    nodes = [kind.node for kind in program.kinds]
    if "storey" not in nodes and "site" not in nodes:
        pytest.skip("the untrained writer drew neither ground nor building")
    if "site" in nodes:
        logs = program.channels[nodes.index("site"), 5:7]
    else:
        logs = program.channels[int(program.parent[nodes.index("storey")]), 5:7]
    assert np.exp(logs) == pytest.approx(outline_m, rel=1e-3)


def test_scenes_are_of_the_theme_that_was_asked_for(corpus):
    own = cached_scene(42)
    other, wishes = encodable([replace(own, theme="fairground")])
    generator = small_generator(learn_language([*corpus[0], *other]), [*corpus[1], *wishes])
    themes = (own.theme, "fairground")
    assert generator._proposer.themes[own.domain] >= set(themes)
    for theme in themes:
        made = raw(generator, *(Request(seed=seed, theme=theme) for seed in range(3)))
        assert [scene.theme for scene in made] == [theme] * 3


@pytest.mark.parametrize("number", [42, 311])
def test_completion_keeps_coarse_objects_as_they_are(generator, number):
    given = cached_scene(number)
    (made,) = raw(generator, Request(seed=6, complete=given))
    assert _coarse(made) == _coarse(given)
    assert made.extent_max_enu_m == given.extent_max_enu_m
    assert any(not obj.is_coarse for obj in made.objects)
    known = {obj.id for obj in made.objects}
    assert all(obj.parent_id is None or obj.parent_id in known for obj in made.objects)


def _coarse(scene):
    coarse = (obj for obj in scene.objects if obj.is_coarse)
    return sorted((obj.category, obj.bbox.p, *sorted(obj.attributes.items())) for obj in coarse)


def test_completion_of_strange_objects_is_refused_in_plain_words(corpus):
    indoors = [pair for pair in zip(*corpus, strict=True) if pair[1].domain == "indoor"]
    generator = small_generator(learn_language([each for each, _ in indoors]), ())
    request = Request(seed=6, complete=cached_scene(42))
    message = "scene '.*' has an object of category '.*', which the model never saw; valid: .*roof"
    with pytest.raises(RequestError, match=message):
        raw(generator, request)


def test_onlooker_sees_scenes_at_every_step(generator):
    seen = []

    def look(moment, proposals):
        seen.append(moment.time)
        scene = proposals[0].scene("noisy", 0, np.random.default_rng(0))
        assert scene.domain in {"outdoor", "indoor", "mixed"}

    raw(generator, Request(seed=0), on_step=look)
    assert seen == sorted(seen, reverse=True)
    assert (len(seen), seen[0]) == (3, 1.0)


def test_wish_stands_for_the_scenes_seen(generator):
    wish, limits = Request(seed=2, n_objects=60).drawn(
        np.random.default_rng(0), generator._seen, is_corpus=True
    )
    assert wish.n_coarse + wish.n_fine == 60
    assert limits is not None
    assert replace(wish, n_coarse=0, n_fine=0, n_areas=0).domain in {"indoor", "outdoor", "mixed"}
