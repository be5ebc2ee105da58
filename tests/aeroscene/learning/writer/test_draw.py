"""Drawing from the writer: what training sees, what is kept, what is the same again."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import torch

from aeroscene.learning.writer.batch import lesson_batch
from aeroscene.learning.writer.config import WriterCfg, WriterError
from aeroscene.learning.writer.draw import _Draw, draw_program
from aeroscene.learning.writer.examples import written
from aeroscene.learning.writer.furnishing import Furnishing
from aeroscene.learning.writer.growth import replay
from aeroscene.learning.writer.lesson import lesson_of, wish_numbers
from aeroscene.learning.writer.stepwise import StepwiseWriter


def test_reading_token_by_token_is_reading_at_once(corpus, language, writer, rng):
    encoded, wish = corpus[0][1], corpus[1][1]
    growth, said = replay(language.syntax, encoded.program, wish)
    draw = _Draw(StepwiseWriter(writer), language.syntax, wish, rng)
    with torch.inference_mode():
        draw.read(growth)
        lesson = lesson_batch([lesson_of(growth, said, wish)])
        n = len(growth.elements)
        before = torch.ones(n, n, dtype=torch.bool).tril()
        mask = torch.stack([before[None], lesson.kin & before], dim=1)
        known = writer.read(lesson.seen, lesson.wish, mask, writer.embedding())
    one_by_one = torch.from_numpy(np.stack(draw.known))
    torch.testing.assert_close(one_by_one, known[0], rtol=1e-4, atol=1e-4)


def test_a_program_longer_than_usual_is_read_to_its_end(language, writer, wish):
    reading = StepwiseWriter(writer).begin(wish_numbers(wish))
    known = [reading.read([0] * 12, np.ones(n + 1, dtype=bool)) for n in range(1100)]
    assert np.isfinite(known).all()
    # All elements are alike, so each sees the same, however many come before it.
    np.testing.assert_allclose(known[-1], known[0], atol=1e-4)


def test_padding_changes_no_loss(corpus, language, writer):
    lessons = [written(*each, language).lesson for each in zip(*corpus, strict=True)]
    with torch.no_grad():
        alone = [writer(lesson_batch([lesson])) for lesson in lessons]
        whole = writer(lesson_batch(lessons))
    for name, value in whole.items():
        expected = sum(float(each[name]) for each in alone)
        assert float(value) == pytest.approx(expected, rel=1e-4)


def test_draws_keep_the_syntax_and_are_the_same_again(language, writer, wish):
    first, again, other = (
        draw_program(StepwiseWriter(writer), language.syntax, wish, np.random.default_rng(seed))
        for seed in (1, 1, 2)
    )
    assert (first.kinds, first.parents) == (again.kinds, again.parents)
    assert first.kinds != other.kinds
    kinds = language.vocabulary.kinds
    assert kinds[first.kinds[0]].domain == wish.domain
    for place, parent in enumerate(first.parents[1:], 1):
        own, above = language.syntax.class_of[[first.kinds[place], first.kinds[parent]]]
        assert language.syntax.most[above, own] > 0


@pytest.mark.parametrize(("least_share", "drawn"), [(0.0, {0, 1, 2}), (0.1, {0, 1}), (1.0, {0})])
def test_what_is_too_rare_is_never_drawn(language, writer, wish, rng, least_share, drawn):
    stepwise = StepwiseWriter(writer)
    stepwise.cfg = replace(stepwise.cfg, least_share=least_share)
    draw = _Draw(stepwise, language.syntax, wish, rng)
    logits = np.log([0.8, 0.16, 0.04])
    assert {draw._choose(logits) for _ in range(400)} == drawn


def test_a_share_out_of_range_is_refused():
    with pytest.raises(WriterError, match=r"least_share 1\.5 is out of range; valid: 0 to 1"):
        WriterCfg(least_share=1.5)


def test_groups_have_arrays_that_the_same_thing_had(language, writer, wish, rng):
    draw = _Draw(StepwiseWriter(writer), language.syntax, wish, rng)
    for kind, each in enumerate(language.vocabulary.kinds):
        known = rng.normal(size=writer.kind[0].in_features).astype(np.float32)
        choice = draw._choice(kind, known)
        assert language.syntax.shapes(kind)[choice.shape]
        assert each.is_group or choice.shape == 0


def test_what_is_kept_comes_first_and_is_furnished(corpus, language, writer, rng):
    program, wish = corpus[0][2].program, corpus[1][2]
    coarse = replace(
        program,
        kinds=program.kinds[: program.n_coarse],
        shapes=program.shapes[: program.n_coarse],
        parent=program.parent[: program.n_coarse],
    )
    given = Furnishing(language.syntax, coarse, wish)
    before = list(given.growth.kinds)
    grown = draw_program(StepwiseWriter(writer), language.syntax, wish, rng, given)
    assert grown.n_coarse == len(before)
    assert grown.kinds[: len(before)] == before
    assert len(grown.kinds) > len(before)


def test_a_domain_that_was_never_seen_is_refused(corpus, writer, rng):
    from aeroscene.learning.writer.language import learn_language

    one = learn_language(corpus[0][:1])
    strange = next(each for each in corpus[1] if each.domain != corpus[1][0].domain)
    with pytest.raises(WriterError, match=r"which the model never saw; valid: \w+$"):
        draw_program(StepwiseWriter(writer), one.syntax, replace(strange), rng)
