"""Numbers that come back exactly are exact again after a diffusion has blurred them."""

import numpy as np
import pytest

from aeroscene.learning.program.atoms import Atoms, atoms_of

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
