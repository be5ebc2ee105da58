"""The default network: what it reads, and what padding and order do to it."""

from __future__ import annotations

from dataclasses import replace

import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from aeroscene.learning.batch import TokenBatch
from aeroscene.learning.model.config import ModelCfg
from aeroscene.learning.model.embedding import ProgramEmbedding
from aeroscene.learning.model.token_denoiser import TokenDenoiser
from tests.aeroscene.learning.model.trees import N_KINDS, N_SHAPES, permuted, tree_batch

CFG = ModelCfg(n_kinds=N_KINDS, width=32, blocks=4)


def untrained(cfg: ModelCfg = CFG) -> TokenDenoiser:
    """A network of kinds that share some traits."""
    traits = torch.arange(cfg.n_kinds)[:, None] % torch.tensor([2, 3, 5]) == 0
    return TokenDenoiser(cfg, ProgramEmbedding(cfg, traits, N_SHAPES))


def denoiser(cfg: ModelCfg = CFG, seed: int = 0) -> TokenDenoiser:
    """A network whose zero-initialised parts were moved off zero, as training does."""
    torch.manual_seed(seed)
    network = untrained(cfg)
    for parameter in network.parameters():
        parameter.data += 0.1 * torch.randn_like(parameter)
    return network


def predict(network: TokenDenoiser, batch: TokenBatch, t: float = 0.4) -> torch.Tensor:
    with torch.no_grad():
        return network(batch.x0, torch.full((batch.n_scenes,), t), batch).output


def test_untrained_network_predicts_zero() -> None:
    batch = tree_batch([(3, 4)], (3, 4))
    assert (predict(untrained(), batch) == 0).all()


@given(
    st.integers(1, 6), st.integers(0, 9), st.integers(0, 5), st.integers(0, 5), st.integers(0, 99)
)
def test_padding_changes_nothing(
    n_coarse: int, n_fine: int, more: int, less: int, seed: int
) -> None:
    tight = tree_batch([(n_coarse, n_fine)], (n_coarse, n_fine), seed)
    loose = tree_batch([(n_coarse, n_fine)], (n_coarse + more, n_fine + less), seed)
    loose.x0[~loose.mask] = 1e3
    network = denoiser()
    out = predict(network, loose)
    assert (out[~loose.mask] == 0).all()
    torch.testing.assert_close(
        out[loose.mask], predict(network, tight)[tight.mask], rtol=1e-4, atol=1e-5
    )


def test_scenes_of_a_batch_do_not_see_each_other() -> None:
    both = tree_batch([(5, 9), (3, 2)], (5, 9), seed=3)
    other = tree_batch([(5, 9), (2, 8)], (5, 9), seed=3)
    network = denoiser()
    torch.testing.assert_close(predict(network, both)[0], predict(network, other)[0])


@given(st.permutations(range(1, 6)), st.permutations(range(6, 14)))
def test_order_of_the_tokens_within_a_scale_is_immaterial(
    coarse: list[int], fine: list[int]
) -> None:
    batch = tree_batch([(6, 8)], (6, 8), seed=1)
    order = torch.tensor([0, *coarse, *fine])
    network = denoiser()
    torch.testing.assert_close(
        predict(network, permuted(batch, order)),
        predict(network, batch)[:, order],
        rtol=1e-4,
        atol=1e-5,
    )


@pytest.mark.parametrize(
    "name", ["kind", "parent", "depth", "ordinal", "twin", "extra", "domain", "wish"]
)
def test_every_part_of_the_skeleton_is_read(name: str) -> None:
    batch, network = tree_batch([(4, 5)], (4, 5), seed=2), denoiser()
    before = predict(network, batch)
    value = getattr(batch, name)
    if name == "parent":
        value[0, -1] = 0 if value[0, -1] else 1
    else:
        value[..., -1] = (
            value[..., -1] + 1 if value.is_floating_point() else (value[..., -1] + 1) % 3
        )
    assert not torch.allclose(before, predict(network, batch))


def test_time_is_read() -> None:
    batch, network = tree_batch([(4, 5)], (4, 5)), denoiser()
    assert not torch.allclose(predict(network, batch, 0.1), predict(network, batch, 0.2))


def test_every_parameter_gets_a_gradient() -> None:
    batch, network = tree_batch([(5, 9), (4, 7)], (5, 9)), denoiser()
    network(batch.x0, torch.tensor([0.2, 0.7]), batch).output.square().sum().backward()
    for name, parameter in network.named_parameters():
        assert parameter.grad is not None, name
        assert parameter.grad.abs().sum() > 0, name


@pytest.mark.parametrize("ablation", [{"fourier_bands": 0}, {"has_narrow_heads": False}])
def test_features_can_be_left_out(ablation: dict) -> None:
    batch = tree_batch([(5, 9)], (5, 9))
    without = predict(denoiser(replace(CFG, **ablation)), batch)
    assert without.isfinite().all()
    assert not torch.equal(without, predict(denoiser(), batch))


def test_bfloat16_on_a_cpu_agrees_with_single_precision() -> None:
    batch, network = tree_batch([(5, 9), (4, 7)], (6, 9)), denoiser()
    exact = predict(network, batch)
    with torch.autocast("cpu", torch.bfloat16):
        coarse = predict(network, batch).float()
    assert (coarse - exact).abs().max() < 0.05 * exact.abs().max()
    assert (coarse != exact).any()


def test_default_has_one_and_a_half_to_three_million_parameters() -> None:
    n = sum(p.numel() for p in untrained(ModelCfg(n_kinds=330)).parameters())
    assert 1.5e6 < n < 3e6
