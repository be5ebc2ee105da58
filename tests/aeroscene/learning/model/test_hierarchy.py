"""Blocks of the default network."""

from __future__ import annotations

import math

import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from aeroscene.learning.model.hierarchy import HierarchyBlock, attend
from aeroscene.learning.model.relations import MASKED, relations_of
from tests.aeroscene.learning.model.trees import tree_batch


@given(st.integers(1, 5), st.integers(1, 6), st.integers(0, 99))
def test_attention_is_the_softmax_of_scaled_products(n_query: int, n_key: int, seed: int) -> None:
    generator = torch.Generator().manual_seed(seed)
    q = torch.randn(2, 3, n_query, 4, generator=generator)
    k, v = torch.randn(2, 2, 3, n_key, 4, generator=generator)
    mask = torch.where(torch.rand(2, 3, n_query, n_key, generator=generator) < 0.4, MASKED, 0.0)
    weight = (q @ k.transpose(-1, -2) / math.sqrt(4) + mask).softmax(-1)
    expected = (weight @ v).transpose(1, 2).reshape(2, n_query, 12)
    torch.testing.assert_close(attend(q, k, v, mask), expected)


def test_half_precision_attention_agrees_with_single() -> None:
    torch.manual_seed(0)
    q, k, v = torch.randn(3, 2, 4, 9, 8)
    mask = torch.where(torch.rand(2, 4, 9, 9) < 0.3, MASKED, 0.0)
    half = attend(q.bfloat16(), k.bfloat16(), v.bfloat16(), mask)
    assert half.dtype == torch.bfloat16
    torch.testing.assert_close(half.float(), attend(q, k, v, mask), atol=0.03, rtol=0.03)


@pytest.mark.parametrize("is_top_down", [True, False])
def test_only_the_asking_scale_sees_the_other(is_top_down: bool) -> None:
    torch.manual_seed(0)
    block = HierarchyBlock(16, 4, 2, is_top_down=is_top_down)
    torch.nn.init.normal_(block.coarse.modulation.weight)
    torch.nn.init.normal_(block.fine.modulation.weight)
    relations = relations_of(tree_batch([(4, 6)], (4, 6)), 4, 16)
    coarse, fine, condition = torch.randn(1, 4, 16), torch.randn(1, 6, 16), torch.randn(1, 16)
    before = block(coarse, fine, condition, relations)
    other_coarse = block(coarse + torch.randn(1, 4, 16), fine, condition, relations)
    other_fine = block(coarse, fine + torch.randn(1, 6, 16), condition, relations)
    assert torch.equal(before[1], other_coarse[1]) is not is_top_down
    assert torch.equal(before[0], other_fine[0]) is is_top_down


def test_untrained_block_is_the_identity() -> None:
    block = HierarchyBlock(16, 4, 2, is_top_down=True)
    relations = relations_of(tree_batch([(4, 6)], (4, 6)), 4, 16)
    coarse, fine = torch.randn(1, 4, 16), torch.randn(1, 6, 16)
    out = block(coarse, fine, torch.randn(1, 16), relations)
    assert torch.equal(out[0], coarse)
    assert torch.equal(out[1], fine)


def test_coarse_token_without_fine_ones_hears_nothing_from_below() -> None:
    torch.manual_seed(0)
    block = HierarchyBlock(16, 4, 2, is_top_down=False)
    torch.nn.init.normal_(block.coarse.modulation.weight)
    relations = relations_of(tree_batch([(3, 0), (3, 4)], (3, 4)), 4, 16)
    coarse, fine, condition = torch.randn(2, 3, 16), torch.randn(2, 4, 16), torch.randn(2, 16)
    first = block(coarse, fine, condition, relations)[0]
    second = block(coarse, torch.randn(2, 4, 16), condition, relations)[0]
    assert torch.equal(first[0], second[0])
    assert not torch.equal(first[1], second[1])
