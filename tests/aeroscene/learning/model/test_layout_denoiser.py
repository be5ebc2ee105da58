"""The paper's network as a whole."""

from __future__ import annotations

from dataclasses import replace

import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from aeroscene.learning.model import ModelCfg
from aeroscene.learning.paper.network.attention import ScaleAttention
from aeroscene.learning.paper.network.layout_denoiser import LayoutDenoiser
from aeroscene.learning.paper.preset import paper_cfg
from aeroscene.learning.tokens.batch import TokenBatch
from tests.aeroscene.learning.model.trees import tree_batch

CFG = replace(
    paper_cfg(6),
    width=16,
    unet_widths=(16, 24),
    grid_shape=(4, 4, 3),
    grid_channels=6,
    graph_radius=1.5,
)


def denoiser(cfg: ModelCfg = CFG) -> LayoutDenoiser:
    torch.manual_seed(0)
    network = LayoutDenoiser(cfg)
    for parameter in network.parameters():
        parameter.data += 0.1 * torch.randn_like(parameter)
    return network


def predict(network: LayoutDenoiser, batch: TokenBatch) -> torch.Tensor:
    with torch.no_grad():
        return network(batch.x0, torch.full((batch.n_scenes,), 0.4), batch).output


@settings(max_examples=15)
@given(
    st.integers(1, 5), st.integers(0, 7), st.integers(0, 4), st.integers(0, 4), st.integers(0, 50)
)
def test_padding_changes_nothing(
    n_coarse: int, n_fine: int, more: int, less: int, seed: int
) -> None:
    tight = tree_batch([(n_coarse, n_fine)], (n_coarse, n_fine), seed, channels=16)
    loose = tree_batch([(n_coarse, n_fine)], (n_coarse + more, n_fine + less), seed, channels=16)
    loose.x0[~loose.mask] = 50.0
    network = denoiser()
    out = predict(network, loose)
    assert (out[~loose.mask] == 0).all()
    torch.testing.assert_close(out[loose.mask], predict(network, tight)[0], rtol=1e-3, atol=1e-4)


def test_every_parameter_learns_the_threshold_too() -> None:
    batch, network = tree_batch([(5, 9), (4, 7)], (5, 9), channels=16), denoiser()
    with torch.no_grad():
        feature = network.embedding(batch.x0, batch).feature
        tau = network.routing(feature, batch.mask).tokenizability
        network.routing.gamma.fill_(tau[batch.mask].median())
    network(batch.x0, torch.tensor([0.2, 0.7]), batch).output.square().sum().backward()
    for name, parameter in network.named_parameters():
        assert parameter.grad is not None, name
        assert parameter.grad.abs().sum() > 0, name


def test_levels_of_the_slots_are_not_read_where_routing_is_learned() -> None:
    batch, network = tree_batch([(4, 6)], (4, 6), channels=16), denoiser()
    assert torch.equal(predict(network, batch), predict(network, replace(batch, n_coarse_slots=2)))


def test_tokenizability_is_reported_for_real_tokens() -> None:
    batch = tree_batch([(3, 5)], (4, 6), channels=16)
    tau = denoiser()(batch.x0, torch.tensor([0.5]), batch).tokenizability
    assert ((tau > 0) == batch.mask).all()
    assert (tau <= 1).all()


@pytest.mark.parametrize("routing", ["learned", "given"])
@pytest.mark.parametrize("coarse_branch", ["cnn", "attention"])
@pytest.mark.parametrize("fine_branch", ["radius_gnn", "siblings"])
def test_parts_can_be_exchanged_one_by_one(
    routing: str, coarse_branch: str, fine_branch: str
) -> None:
    cfg = replace(
        CFG,
        routing=routing,
        coarse_branch=coarse_branch,
        fine_branch=fine_branch,
    )
    batch, network = tree_batch([(4, 6)], (4, 6), channels=16), denoiser(cfg)
    prediction = network(batch.x0, torch.tensor([0.5]), batch)
    assert prediction.output.isfinite().all()
    assert prediction.output.shape == batch.x0.shape
    assert (prediction.tokenizability is None) == (routing == "given")
    assert isinstance(network.coarse, ScaleAttention) == (coarse_branch == "attention")
    assert isinstance(network.fine, ScaleAttention) == (fine_branch == "siblings")


def test_paper_preset_has_at_most_seven_million_parameters() -> None:
    network = LayoutDenoiser(paper_cfg(70))
    assert network.cfg.channels == 80
    assert sum(parameter.numel() for parameter in network.parameters()) < 7e6
