"""How rare is too rare to be drawn is told by what held-out scenes have."""

from __future__ import annotations

import copy

import pytest
import torch

from aeroscene.learning.training.writer_stage import with_fitting_share
from aeroscene.learning.writer.batch import lesson_batch
from aeroscene.learning.writer.config import WriterCfg
from aeroscene.learning.writer.examples import written
from aeroscene.learning.writer.model import shares_of_likeliest
from aeroscene.learning.writer.training_set import LessonSet


@pytest.fixture(scope="module")
def held_out(corpus, language):
    return LessonSet(tuple(written(*each, language) for each in zip(*corpus, strict=True)))


def fitted(writer, language, held_out) -> WriterCfg:
    return with_fitting_share(writer.cfg, writer.state_dict(), language, held_out)


def test_a_writer_to_whom_all_is_likely_leaves_out_what_it_may(language, writer, held_out):
    assert fitted(writer, language, held_out) == writer.cfg


def test_a_writer_to_whom_much_that_is_there_is_rare_leaves_out_less(language, writer, held_out):
    one_sided = copy.deepcopy(writer)
    with torch.no_grad():
        one_sided.bias[0] = 5.0
    found = fitted(one_sided, language, held_out).least_share
    assert 0.0 < found < writer.cfg.least_share
    with torch.no_grad():
        batch = lesson_batch([each.lesson for each in held_out.examples])
        shares = shares_of_likeliest(one_sided, batch)
    assert float((shares < found).float().mean()) <= 0.075
    assert float((shares < writer.cfg.least_share).float().mean()) > 0.5


def test_without_held_out_scenes_it_stays(language, writer):
    assert fitted(writer, language, LessonSet(())) == writer.cfg
