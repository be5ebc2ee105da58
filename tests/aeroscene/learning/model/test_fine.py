"""The radius graph and the paper's node update."""

from __future__ import annotations

import torch
from hypothesis import given
from hypothesis import strategies as st
from torch import Tensor, nn

from aeroscene.learning.paper.network.fine import FineGnn, GnnLayer, radius_graph


def draw(n: int, seed: int) -> tuple[Tensor, Tensor, Tensor]:
    generator = torch.Generator().manual_seed(seed)
    is_fine = torch.rand(1, n, generator=generator) < 0.7
    feature = torch.randn(1, n, 8, generator=generator)
    return feature, torch.randn(1, n, 3, generator=generator), is_fine


@given(st.integers(1, 12), st.integers(0, 99), st.floats(0.2, 4.0))
def test_graph_joins_fine_pairs_within_the_radius(n: int, seed: int, radius: float) -> None:
    _, position, is_fine = draw(n, seed)
    graph = radius_graph(position, is_fine, radius)[0]
    for i in range(n):
        for j in range(n):
            near = (position[0, i] - position[0, j]).norm() <= radius
            assert graph[i, j] == (near and i != j and is_fine[0, i] and is_fine[0, j])


def by_hand(layer: GnnLayer, feature: Tensor, graph: Tensor) -> Tensor:
    """f_i <- MLP(f_i || sum_{j in A_i} MLP(f_j)), node by node."""

    def mlp(part: nn.Sequential, x: Tensor) -> Tensor:
        return part[2].weight @ nn.functional.silu(part[0].weight @ x + part[0].bias) + part[2].bias

    rows = []
    for i in range(len(feature)):
        summed = torch.zeros_like(feature[i])
        for j in range(len(feature)):
            if graph[i, j]:
                summed = summed + mlp(layer.message, feature[j])
        rows.append(mlp(layer.update, torch.cat([feature[i], summed])))
    return torch.stack(rows)


@given(st.integers(1, 9), st.integers(0, 99))
def test_two_layers_are_the_equation_applied_twice(n: int, seed: int) -> None:
    torch.manual_seed(0)
    gnn = FineGnn(8, radius=1.5)
    feature, position, is_fine = draw(n, seed)
    with torch.no_grad():
        found = gnn(feature, is_fine, position)[0]
        graph = radius_graph(position, is_fine, 1.5)[0]
        expected = by_hand(gnn.layers[1], by_hand(gnn.layers[0], feature[0], graph), graph)
    torch.testing.assert_close(found, expected, rtol=1e-4, atol=1e-5)


@given(st.permutations(range(8)))
def test_branch_does_not_ask_for_an_order(order: list[int]) -> None:
    torch.manual_seed(0)
    gnn = FineGnn(8, radius=1.5)
    feature, position, is_fine = draw(8, 5)
    moved = gnn(feature[:, order], is_fine[:, order], position[:, order])
    torch.testing.assert_close(
        moved, gnn(feature, is_fine, position)[:, order], rtol=1e-4, atol=1e-5
    )
