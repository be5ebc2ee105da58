"""The UNet over the list of tokens."""

from __future__ import annotations

import torch
from hypothesis import given
from hypothesis import strategies as st

from aeroscene.learning.paper.network.unet import Condition, TokenUnet


def unet() -> TokenUnet:
    torch.manual_seed(0)
    network = TokenUnet(channels=5, condition=16, widths=(8, 12, 16), heads=4)
    for parameter in network.parameters():
        parameter.data += 0.1 * torch.randn_like(parameter)
    return network


def inputs(n: int, padding: int, seed: int = 0) -> tuple[torch.Tensor, ...]:
    generator = torch.Generator().manual_seed(seed)
    whole = torch.full((1, n + padding, 29), 30.0)
    whole[:, :n] = torch.randn(1, n, 29, generator=generator)
    x_t, position, feature = whole.split([5, 8, 16], -1)
    mask = (torch.arange(n + padding) < n).unsqueeze(0)
    return x_t, position, mask, torch.randn(1, 16, generator=generator), feature


def predict(network: TokenUnet, n: int, padding: int, seed: int = 0) -> torch.Tensor:
    x_t, position, mask, time, feature = inputs(n, padding, seed)
    with torch.no_grad():
        return network(x_t, position, mask, Condition(time, feature, mask.unsqueeze(1)))


@given(st.integers(1, 13), st.integers(0, 9), st.integers(0, 20))
def test_padding_changes_nothing(n: int, padding: int, seed: int) -> None:
    network = unet()
    exact = predict(network, n, 0, seed)
    assert exact.shape == (1, n, 5)
    padded = predict(network, n, padding, seed)[:, :n]
    torch.testing.assert_close(padded, exact, rtol=1e-3, atol=1e-4)


def test_condition_enters_by_cross_attention_at_every_level() -> None:
    network = unet()
    x_t, position, mask, time, feature = inputs(9, 0)
    feature = feature.clone().requires_grad_()
    network(x_t, position, mask, Condition(time, feature, mask.unsqueeze(1))).sum().backward()
    assert (feature.grad.abs().sum(-1) > 0).all()
    for block in (*network.down, network.middle, *network.up):
        assert block.attention.key.weight.grad.abs().sum() > 0


def test_untrained_prediction_is_zero() -> None:
    torch.manual_seed(0)
    network = TokenUnet(channels=5, condition=16, widths=(8, 12), heads=4)
    assert (predict(network, 6, 2) == 0).all()
