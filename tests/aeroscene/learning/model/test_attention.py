"""Cross-scale Progressive Attention."""

from __future__ import annotations

import math

import torch
from torch import Tensor, nn

from aeroscene.learning.paper.network.attention import (
    CrossScaleProgressiveAttention,
    MaskedAttention,
    ScaleAttention,
)
from aeroscene.learning.paper.network.routing import Routes, given_routes
from tests.aeroscene.learning.model.trees import tree_batch


def by_hand(block: MaskedAttention, feature: Tensor, source: Tensor, allowed: Tensor) -> Tensor:
    """F' = FC(Attn(LN Q, LN K, LN V)) + F, head by head."""
    q = block.query(block.query_norm(feature))
    k = block.key(block.key_norm(source))
    v = block.value(block.value_norm(source))
    width = q.shape[-1] // block.heads
    heads = []
    for h in range(block.heads):
        part = slice(h * width, (h + 1) * width)
        logits = q[..., part] @ k[..., part].transpose(-1, -2) / math.sqrt(width)
        heads.append(logits.masked_fill(~allowed, -torch.inf).softmax(-1) @ v[..., part])
    return block.fc(torch.cat(heads, -1)) + feature


def test_block_is_the_equation() -> None:
    torch.manual_seed(0)
    block = MaskedAttention(16, 4, key_width=12)
    feature, source = torch.randn(2, 5, 16), torch.randn(2, 7, 12)
    allowed = torch.rand(2, 5, 7) < 0.5
    allowed[..., 0] = True
    found = block(feature, source, allowed)
    assert found.shape == feature.shape
    torch.testing.assert_close(found, by_hand(block, feature, source, allowed))


def test_row_without_a_key_stays_as_it_is() -> None:
    torch.manual_seed(0)
    block = MaskedAttention(16, 4)
    feature = torch.randn(1, 3, 16, requires_grad=True)
    allowed = torch.ones(1, 3, 3, dtype=torch.bool)
    allowed[0, 1] = False
    found = block(feature, feature, allowed)
    assert torch.equal(found[0, 1], feature[0, 1])
    found.sum().backward()
    assert feature.grad.isfinite().all()


def test_keys_that_are_not_allowed_have_no_influence() -> None:
    torch.manual_seed(0)
    block = MaskedAttention(16, 4)
    feature, source = torch.randn(1, 3, 16), torch.randn(1, 4, 16)
    allowed = torch.tensor([[[True, True, False, False]]])
    other = source.clone()
    other[:, 2:] = 50.0
    assert torch.equal(block(feature, source, allowed), block(feature, other, allowed))


def routes_of(counts: tuple[int, int]) -> Routes:
    return given_routes(tree_batch([counts], (4, 6)))


def test_blocks_alternate_from_top_down_to_bottom_up() -> None:
    torch.manual_seed(0)
    routes, feature = routes_of((4, 6)), torch.randn(1, 10, 16)
    coarse, fine = feature[:, :4], feature[:, 4:]
    attention = CrossScaleProgressiveAttention(16, 4, blocks=2)
    down, up = attention.blocks
    asked = by_hand(down, fine, coarse, torch.ones(1, 6, 4, dtype=torch.bool))
    answered = by_hand(up, coarse, asked, torch.ones(1, 4, 6, dtype=torch.bool))
    expected = attention.project(torch.cat([answered, asked], 1))
    found = attention(feature, routes)
    assert found.shape == (1, 10, 16)
    torch.testing.assert_close(found, expected)


def test_scene_of_one_scale_passes_through() -> None:
    torch.manual_seed(0)
    attention = CrossScaleProgressiveAttention(16, 4, blocks=4)
    attention.project = nn.Identity()
    feature = torch.randn(1, 10, 16)
    assert torch.equal(attention(feature, routes_of((4, 0)))[:, :4], feature[:, :4])


def test_siblings_see_those_of_their_parent_alone() -> None:
    torch.manual_seed(0)
    branch = ScaleAttention(16, 4, of_siblings=True)
    feature, everyone = torch.randn(1, 4, 16), torch.ones(1, 4, dtype=torch.bool)
    parent = torch.tensor([[0, 0, 1, 1]])
    other = feature.clone()
    other[:, 3] += 1.0
    before, after = branch(feature, everyone, parent), branch(other, everyone, parent)
    assert torch.equal(before[:, :2], after[:, :2])
    assert not torch.equal(before[:, 2], after[:, 2])
