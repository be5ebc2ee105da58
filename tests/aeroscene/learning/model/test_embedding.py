"""From noisy channels to tokens."""

from __future__ import annotations

import torch
from torch import Tensor

from aeroscene.learning.model import ModelCfg
from aeroscene.learning.model.embedding import LayoutEmbedding, TokenEmbedding
from aeroscene.learning.model.encoding import sinusoid
from aeroscene.learning.paper.preset import paper_cfg
from aeroscene.learning.tokens.batch import TokenBatch
from tests.aeroscene.learning.model.trees import N_KINDS, tree_batch


def test_paper_token_is_feature_plus_position_plus_domain() -> None:
    torch.manual_seed(0)
    embedding = LayoutEmbedding(paper_cfg(6))
    batch = tree_batch([(2, 3)], (3, 3), channels=16)
    x_t = batch.x0
    feature, token, place = embedding(x_t, batch)
    category = x_t[..., 10:] @ embedding.category.weight.T
    expected = embedding.mlp(torch.cat([x_t[..., :10], category], -1))
    torch.testing.assert_close(feature, expected)
    order = torch.tensor([0, 1, 1, 2, 3, 4])
    torch.testing.assert_close(place[0], sinusoid(order, 128))
    domain = embedding.domain.weight[batch.domain[0]]
    torch.testing.assert_close(token[0], feature[0] + place[0] + domain)


def test_soft_category_of_a_one_hot_vector_is_its_row() -> None:
    torch.manual_seed(0)
    embedding = LayoutEmbedding(paper_cfg(6))
    one_hot = torch.eye(6)
    torch.testing.assert_close(embedding.category(one_hot), embedding.category.weight.T)


def token_embedding() -> TokenEmbedding:
    torch.manual_seed(0)
    return TokenEmbedding(ModelCfg(n_kinds=N_KINDS, width=16))


def changed_tokens(embedding: TokenEmbedding, batch: TokenBatch, token: int) -> Tensor:
    """Which tokens notice that the channels of one are others."""
    changed = batch.x0.clone()
    changed[0, token] += 1.0
    with torch.no_grad():
        before, after = embedding(batch.x0, batch), embedding(changed, batch)
    return (before != after).any(-1)[0]


def test_token_knows_its_parents_noisy_channels_and_nobody_elses() -> None:
    torch.manual_seed(0)
    embedding = TokenEmbedding(ModelCfg(n_kinds=N_KINDS, width=16, has_borders=False))
    batch = tree_batch([(3, 5)], (3, 5), seed=4)
    differs = changed_tokens(embedding, batch, 1)
    assert torch.equal(differs, (batch.parent[0] == 1) | (torch.arange(8) == 1))
    assert (batch.parent[0] == 1).any()


def test_borders_move_with_every_ancestor_and_with_nothing_else() -> None:
    batch = tree_batch([(3, 9)], (3, 9), seed=4)
    parent = batch.parent[0].tolist()
    below = [False] * len(parent)
    for i in range(1, len(parent)):
        below[i] = i == 1 or below[parent[i]]
    assert sum(below) > sum(p == 1 for p in parent)
    assert changed_tokens(token_embedding(), batch, 1).tolist() == below


def _square_metres() -> tuple[Tensor, Tensor]:
    """All extents absolute, all kinds square to their parents."""
    return torch.zeros(N_KINDS, 3, dtype=torch.bool), torch.ones(N_KINDS, dtype=torch.bool)


def test_statistics_scale_by_kind() -> None:
    embedding = token_embedding()
    mean, spread = torch.randn(N_KINDS, 15), torch.rand(N_KINDS, 15)
    embedding.use_statistics(mean, spread, *_square_metres())
    batch = tree_batch([(2, 2)], (2, 2))
    value = embedding.own_units(batch.x0, batch.kind)
    for i, kind in enumerate(batch.kind[0].tolist()):
        torch.testing.assert_close(value[0, i], mean[kind] + spread[kind] * batch.x0[0, i])
    assert embedding.own_units(1e6 * batch.x0, batch.kind).abs().max() == 8.0


def test_statistics_travel_with_the_weights() -> None:
    told = token_embedding()
    told.use_statistics(torch.randn(N_KINDS, 15), torch.rand(N_KINDS, 15), *_square_metres())
    other = token_embedding()
    other.load_state_dict(told.state_dict())
    batch = tree_batch([(2, 2)], (2, 2))
    assert torch.equal(told(batch.x0, batch), other(batch.x0, batch))
