"""Masks of the tree against the definitions, token by token."""

from __future__ import annotations

import torch
from hypothesis import given
from hypothesis import strategies as st

from aeroscene.learning.batch import TokenBatch
from aeroscene.learning.model.relations import coarse_ancestors, nearest_coarse, relations_of
from tests.aeroscene.learning.model.trees import tree_batch

counts = st.tuples(st.integers(1, 6), st.integers(0, 9))


def chain(batch: TokenBatch, row: int, slot: int) -> list[int]:
    """Ancestors of a token, the nearest first, the site last."""
    above = [int(batch.parent[row, slot])]
    while above[-1] != 0:
        above.append(int(batch.parent[row, above[-1]]))
    return above


@given(counts, st.integers(0, 99))
def test_ancestors_are_those_met_on_the_way_to_the_site(pair: tuple[int, int], seed: int) -> None:
    batch = tree_batch([pair], (7, 10), seed)
    nearest = nearest_coarse(batch.parent, 7)
    found = coarse_ancestors(batch.parent, 7, nearest)[0]
    for j in range(pair[1]):
        coarse = [slot for slot in chain(batch, 0, 7 + j) if slot < 7]
        assert found[j].nonzero().flatten().tolist() == sorted(coarse)
        assert nearest[0, 7 + j] == coarse[0]


@given(counts, st.integers(0, 99))
def test_masks_hold_the_relations_of_the_table(pair: tuple[int, int], seed: int) -> None:
    batch = tree_batch([pair], (7, 10), seed)
    relations = relations_of(batch, heads=4, width=8)
    nearest = nearest_coarse(batch.parent, 7)[0].tolist()
    parent, (n_coarse, n_fine) = batch.parent[0].tolist(), pair
    open_to = {name: (value[0] == 0) for name, value in relations._asdict().items()}
    for i in range(n_coarse):
        kin = [
            j
            for j in range(n_coarse)
            if i == j or parent[i] == parent[j] or parent[i] == j or parent[j] == i
        ]
        assert allowed(open_to["coarse_self"], i) == [list(range(n_coarse)), kin]
        own = [j for j in range(n_fine) if nearest[7 + j] == i]
        assert allowed(open_to["bottom_up"], i) == [list(range(n_fine)), own]
        has = relations.has_fine[0, i]
        assert has.tolist() == [float(n_fine > 0)] * 4 + [float(bool(own))] * 4
    for i in range(n_fine):
        family = [j for j in range(n_fine) if nearest[7 + j] == nearest[7 + i]]
        siblings = [j for j in range(n_fine) if parent[7 + j] == parent[7 + i]]
        assert allowed(open_to["fine_self"], i) == [family, siblings]
        above = sorted(slot for slot in chain(batch, 0, 7 + i) if slot < 7)
        assert allowed(open_to["top_down"], i) == [list(range(n_coarse)), above]


def test_without_narrow_heads_all_see_the_wide_relation() -> None:
    batch = tree_batch([(5, 8)], (6, 9))
    narrow, wide = relations_of(batch, 4, 8), relations_of(batch, 4, 8, has_narrow_heads=False)
    for with_narrow, without in zip(narrow, wide, strict=True):
        half = with_narrow.shape[1] // 2 if with_narrow.ndim == 4 else None
        if half is None:
            torch.testing.assert_close(without[..., 4:], with_narrow[..., :4])
        else:
            assert torch.equal(without, with_narrow[:, :half].repeat(1, 2, 1, 1))


def allowed(is_open: torch.Tensor, query: int) -> list[list[int]]:
    """Keys of a query in the wide heads and in the narrow ones, which agree among each other."""
    assert (is_open[0] == is_open[1]).all()
    assert (is_open[2] == is_open[3]).all()
    return [is_open[head, query].nonzero().flatten().tolist() for head in (0, 2)]
