"""The voxel grid of the coarse branch."""

from __future__ import annotations

import torch
from hypothesis import given
from hypothesis import strategies as st

from aeroscene.learning.paper.network.coarse import CoarseCnn, splat_mean, trilinear_weights

SHAPE = (5, 4, 3)
N_VOXELS = 60


def draw(n: int, seed: int, spread: float = 1.0) -> tuple[torch.Tensor, torch.Tensor]:
    generator = torch.Generator().manual_seed(seed)
    feature = torch.randn(2, n, 6, generator=generator)
    return feature, spread * torch.randn(2, n, 3, generator=generator)


@given(st.integers(1, 9), st.integers(0, 99), st.floats(0.1, 5.0))
def test_each_token_is_on_the_grid_once(n: int, seed: int, spread: float) -> None:
    shares = trilinear_weights(draw(n, seed, spread)[1], SHAPE, 2.0)
    assert shares.shape == (2, n, N_VOXELS)
    assert (shares >= 0).all()
    assert ((shares > 0).sum(-1) <= 8).all()
    torch.testing.assert_close(shares.sum(-1), torch.ones(2, n))


@given(st.integers(1, 9), st.integers(0, 99))
def test_splatting_keeps_the_sum(n: int, seed: int) -> None:
    feature, position = draw(n, seed)
    is_there = torch.rand(2, n, generator=torch.Generator().manual_seed(seed)) < 0.7
    weight = is_there.float().unsqueeze(-1)
    mean, amount = splat_mean(feature, is_there, trilinear_weights(position, SHAPE, 2.0))
    torch.testing.assert_close(amount.sum(1), weight.sum(1))
    torch.testing.assert_close(
        (mean * amount).sum(1), (feature * weight).sum(1), rtol=1e-4, atol=1e-3
    )


@given(st.integers(0, 99), st.floats(0.1, 5.0))
def test_lone_token_is_gathered_as_it_was_splatted(seed: int, spread: float) -> None:
    feature, position = draw(1, seed, spread)
    shares = trilinear_weights(position, SHAPE, 2.0)
    mean, _ = splat_mean(feature, torch.ones(2, 1, dtype=torch.bool), shares)
    torch.testing.assert_close(shares @ mean, feature, rtol=1e-3, atol=1e-3)


def test_gathering_a_linear_field_is_exact() -> None:
    axes = [torch.linspace(-2.0, 2.0, k) for k in SHAPE]
    field = torch.stack(torch.meshgrid(*axes, indexing="ij"), -1).reshape(1, N_VOXELS, 3)
    _, position = draw(20, 0, 0.6)
    position = position.clamp(-2, 2)
    found = trilinear_weights(position, SHAPE, 2.0) @ field.expand(2, -1, -1)
    torch.testing.assert_close(found, position, atol=1e-5, rtol=0)


def test_positions_beyond_the_grid_count_on_its_border() -> None:
    far = trilinear_weights(torch.tensor([[[9.0, -9.0, 0.0]]]), SHAPE, 2.0)
    near = trilinear_weights(torch.tensor([[[2.0, -2.0, 0.0]]]), SHAPE, 2.0)
    assert torch.equal(far, near)


def cnn() -> CoarseCnn:
    torch.manual_seed(0)
    return CoarseCnn(width=6, channels=4, shape=SHAPE, reach=2.0)


def test_branch_does_not_ask_for_an_order() -> None:
    feature, position = draw(7, 1)
    everyone, order = torch.ones(2, 7, dtype=torch.bool), torch.randperm(7)
    branch = cnn()
    moved = branch(feature[:, order], everyone, position[:, order])
    torch.testing.assert_close(
        moved, branch(feature, everyone, position)[:, order], atol=1e-5, rtol=1e-4
    )


def test_fine_tokens_are_not_on_the_grid() -> None:
    feature, position = draw(7, 2)
    is_coarse = torch.arange(7).expand(2, 7) < 4
    other = feature.clone()
    other[:, 4:] = 100.0
    branch = cnn()
    assert torch.equal(
        branch(feature, is_coarse, position)[:, :4], branch(other, is_coarse, position)[:, :4]
    )


def test_tokens_feel_their_neighbours_but_not_those_beyond_two_convolutions() -> None:
    branch = CoarseCnn(width=6, channels=4, shape=(20, 3, 3), reach=2.0)
    feature = torch.randn(1, 2, 6)
    both = torch.ones(1, 2, dtype=torch.bool)

    def first(x_of_second: float, second: torch.Tensor) -> torch.Tensor:
        position = torch.tensor([[[-2.0, 0.0, 0.0], [x_of_second, 0.0, 0.0]]])
        return branch(torch.stack([feature[:, 0], second], 1), both, position)[:, 0]

    assert not torch.equal(first(-1.8, feature[:, 1]), first(-1.8, -feature[:, 1]))
    assert torch.equal(first(1.8, feature[:, 1]), first(1.8, -feature[:, 1]))
