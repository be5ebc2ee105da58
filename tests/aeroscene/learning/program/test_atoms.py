"""Numbers that come back exactly are exact again after a diffusion has blurred them."""

from dataclasses import replace

import numpy as np
import pytest

from aeroscene.corpus.curation import curate_layout
from aeroscene.learning.generation.denoising import Draft, ProgramProposal
from aeroscene.learning.program import DecodingCfg, encode
from aeroscene.learning.program.atoms import Atoms, atoms_of
from aeroscene.learning.program.references import group_of
from aeroscene.learning.program.statistics import from_example, to_example
from aeroscene.learning.wishes import Wish
from aeroscene.learning.writer.language import Language, learn_language

DOORS_M = np.repeat([2.35, 2.85], [30, 50])


def snapped(values, drawn):
    row = np.array([drawn])
    Atoms({"door": {**atoms_of(values[:, None], [0])}}).snap("door", row)
    return row[0]


@pytest.mark.parametrize(("drawn", "wanted"), [(2.31, 2.35), (2.5, 2.35), (2.7, 2.85), (3.2, 2.85)])
def test_what_is_always_one_of_a_few_values_is_the_nearest_of_them(drawn, wanted):
    assert snapped(DOORS_M, drawn) == wanted


def test_values_spread_evenly_stay_as_they_are_drawn():
    values = np.linspace(0.0, 1.0, 400)
    assert snapped(values, 0.501) == 0.501


def test_an_atom_reaches_no_further_than_there_is_little_else():
    """Four in five lie on the wall, others anywhere from 0.1 m on: these are not drawn to it."""
    values = np.concatenate([np.zeros(400), np.linspace(0.1, 1.0, 100)])
    assert snapped(values, 0.05) == 0.0
    assert snapped(values, 0.6) == 0.6


def test_what_a_token_has_not_stays_nothing():
    assert np.isnan(snapped(DOORS_M, np.nan))


def test_a_group_that_was_never_seen_has_no_atoms():
    row = np.array([2.4])
    Atoms({}).snap("gate", row)
    assert row[0] == 2.4


@pytest.fixture(scope="module")
def learned():
    encoded = [encode(curate_layout(seed)) for seed in (7, 13, 16, 19)]
    return encoded, learn_language(encoded)


def test_a_checkpoint_keeps_the_atoms_of_its_scenes(learned):
    _, language = learned
    kept = Language.restored(language.to_json(), language.to_arrays()).statistics.atoms.by_group
    ours = language.statistics.atoms.by_group
    assert kept.keys() == ours.keys()
    assert len(ours) > 3
    for group, channels in ours.items():
        assert kept[group].keys() == channels.keys()
        for channel, (values, reaches) in channels.items():
            np.testing.assert_allclose(kept[group][channel][0], values, atol=1e-5)
            np.testing.assert_allclose(kept[group][channel][1], reaches, rtol=1e-5)


def n_on_atoms(program, atoms):
    return sum(
        any(value == atom for atom in atoms.by_group[group_of(kind)][channel][0])
        for kind, row in zip(program.kinds, program.channels, strict=True)
        for channel, value in enumerate(row)
        if channel in atoms.by_group.get(group_of(kind), {})
    )


def test_numbers_that_are_drawn_are_put_on_atoms(learned):
    encoded, language = learned
    example = to_example(encoded[0], language.vocabulary, language.statistics)
    noise = np.random.default_rng(0).normal(0.0, 0.05, example.x0.shape)
    blurred = replace(example, x0=example.x0 + noise)
    draft = Draft(blurred, Wish("outdoor", 30, 90, 50))
    atoms = language.statistics.atoms
    drawn = ProgramProposal(blurred, language, draft, DecodingCfg()).program
    as_blurred = from_example(blurred, language.vocabulary, language.statistics)
    assert n_on_atoms(drawn, atoms) > n_on_atoms(as_blurred, atoms) + 15
