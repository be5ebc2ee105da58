"""The UNet over the list of tokens."""

from __future__ import annotations

import torch
from hypothesis import given
from hypothesis import strategies as st
from torch import Tensor

from aeroscene.learning.paper.network.unet import Condition, TokenUnet


def unet() -> TokenUnet:
    torch.manual_seed(0)
    network = TokenUnet(inward=6, channels=5, condition=16, widths=(8, 12, 16), heads=4)
    for parameter in network.parameters():
        parameter.data += 0.1 * torch.randn_like(parameter)
    return network


def inputs(n: int, padding: int, seed: int = 0) -> tuple[Tensor, Condition]:
    generator = torch.Generator().manual_seed(seed)
    whole = torch.full((1, n + padding, 38), 30.0)
    whole[:, :n] = torch.randn(1, n, 38, generator=generator)
    place, time, feature = whole.split([6, 16, 16], -1)
    mask = (torch.arange(n + padding) < n).view(1, 1, -1)
    near = torch.zeros(1, 4, n + padding, n + padding)
    near[..., :n, :n] = torch.randn(1, 4, n, n, generator=generator)
    return place, Condition(time, feature, mask, near)


@given(st.integers(1, 13), st.integers(0, 9), st.integers(0, 20))
def test_padding_changes_nothing(n: int, padding: int, seed: int) -> None:
    network = unet()
    with torch.no_grad():
        exact = network(*inputs(n, 0, seed))
        padded = network(*inputs(n, padding, seed))[:, :n]
    assert exact.shape == (1, n, 5)
    torch.testing.assert_close(padded, exact, rtol=1e-3, atol=1e-4)


def test_condition_enters_by_cross_attention_at_every_level() -> None:
    network = unet()
    place, condition = inputs(9, 0)
    feature = condition.feature.clone().requires_grad_()
    near = condition.nearness.clone().requires_grad_()
    network(place, Condition(condition.time, feature, condition.is_token, near)).sum().backward()
    assert (feature.grad.abs().sum(-1) > 0).all()
    assert (near.grad.abs().sum((0, 2, 3)) > 0).all()
    for block in (*network.down, network.middle, *network.up):
        assert block.across.key.weight.grad.abs().sum() > 0
        assert block.within.key.weight.grad.abs().sum() > 0


def test_how_large_the_input_is_reaches_the_output() -> None:
    """Through LayerNorms alone it could not: this was the fault of the paper's preset."""
    network = unet()
    place, condition = inputs(9, 0)
    with torch.no_grad():
        one, twice, more = (network(k * place, condition) for k in (1e3, 2e3, 3e3))
    assert (twice - one).abs().mean() > 10
    torch.testing.assert_close(more - twice, twice - one, rtol=0.05, atol=1.0)


def test_untrained_prediction_is_zero() -> None:
    torch.manual_seed(0)
    network = TokenUnet(inward=6, channels=5, condition=16, widths=(8, 12), heads=4)
    with torch.no_grad():
        assert (network(*inputs(6, 2)) == 0).all()
