from dataclasses import replace

import pytest
import torch

from aeroscene.learning.diffusion.sampling import Moment
from aeroscene.learning.guidance.alignment import AlignmentGuidance
from aeroscene.learning.guidance.borders import BorderGuidance
from aeroscene.learning.guidance.config import NO_GUIDANCE, GuidanceCfg, guidance_of
from aeroscene.learning.guidance.separation import SeparationGuidance
from aeroscene.learning.paper.guidance.objectives import ObjectivesCfg
from aeroscene.learning.tokens.decode import TreeDecoder
from aeroscene.learning.tokens.training_set import training_set
from tests.aeroscene.conftest import cached_scene

LAST = Moment(index=9, n_steps=10, time=0.1, alpha_bar=0.9, fixed=None)
CPU = torch.device("cpu")


@pytest.fixture(scope="module")
def noisy():
    """Decoder, vocabulary, tokens and a layout that overlaps."""
    known = training_set([cached_scene(index) for index in (7, 42)])
    batch = known.collator.examples(known.examples[:1])
    assert batch.x0 is not None
    assert batch.weight is not None
    noise = torch.randn(batch.x0.shape, generator=torch.Generator().manual_seed(0))
    decoder = TreeDecoder(known.vocabulary, known.statistics)
    return decoder, known.vocabulary, batch, batch.x0 + 0.1 * noise * batch.weight


def test_without_parts_there_is_no_guidance(noisy):
    decoder, vocabulary, *_ = noisy
    assert guidance_of(NO_GUIDANCE, decoder, vocabulary, CPU) is None


def test_default_aligns_between_borders_and_separation(noisy):
    decoder, vocabulary, batch, x0 = noisy
    chain = guidance_of(GuidanceCfg(), decoder, vocabulary, CPU)
    assert chain is not None
    by_borders = BorderGuidance(decoder, vocabulary, CPU).on_x0(x0, batch, LAST)
    in_line = AlignmentGuidance(decoder, vocabulary).on_x0(by_borders, batch, LAST)
    by_all = SeparationGuidance(decoder.decode, decoder.bounds).on_x0(in_line, batch, LAST)
    assert not torch.equal(by_borders, in_line)
    assert not torch.equal(in_line, by_all)
    assert torch.equal(chain.on_x0(x0, batch, LAST), by_all)
    assert torch.equal(chain.on_mean(x0, x0, batch, LAST), x0)


def test_papers_objectives_move_the_mean_alone(noisy):
    decoder, vocabulary, batch, x0 = noisy
    cfg = replace(NO_GUIDANCE, objectives=ObjectivesCfg(step_size=0.3))
    chain = guidance_of(cfg, decoder, vocabulary, CPU)
    assert chain is not None
    assert torch.equal(chain.on_x0(x0, batch, LAST), x0)
    way = chain.on_mean(x0, x0, batch, LAST) - x0
    # eta_0 sqrt(1 - alpha_bar), whatever the gradient's length.
    assert float(way.norm()) == pytest.approx(0.3 * 0.1**0.5, rel=1e-3)
