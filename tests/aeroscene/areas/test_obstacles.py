import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from aeroscene.areas.obstacles import Obstructions

FACE = shapely.box(0, 0, 10, 8)


def _obstructions(outlines: list[shapely.Polygon]) -> Obstructions:
    taken = np.array(outlines, dtype=object)
    return Obstructions(taken, np.zeros(len(taken)), np.ones(len(taken)))


def _outlines(seed: int) -> list[shapely.Polygon]:
    """Boxes here and there, some within others, some twice, some beside the face."""
    rng = np.random.default_rng(seed)
    low = rng.integers(-4, 20, (12, 2)) / 2
    size = rng.integers(1, 8, (12, 2)) / 2
    found = [shapely.box(*a, *(a + s)) for a, s in zip(low, size, strict=True)]
    inner = [shapely.box(*(a + s / 4), *(a + s / 2)) for a, s in zip(low, size, strict=True)]
    return [*found, *inner[:6], *found[:3]]


@given(st.integers(0, 10_000))
def test_what_is_left_is_what_no_outline_covers(seed):
    outlines = _outlines(seed)
    left = _obstructions(outlines).subtracted_from(FACE)
    expected = shapely.difference(FACE, shapely.union_all(outlines))
    assert shapely.symmetric_difference(left, expected).area == pytest.approx(0, abs=1e-4)


def test_nothing_is_left_below_a_roof():
    roof, table = shapely.box(-1, -1, 11, 9), shapely.box(2, 2, 3, 3)
    assert _obstructions([table, roof]).subtracted_from(FACE).is_empty


def test_what_stands_elsewhere_takes_nothing():
    left = _obstructions([shapely.box(20, 0, 22, 2)]).subtracted_from(FACE)
    assert left.equals(FACE)
