"""tau = sigma(w . MLP(f)), compared with a gamma that learns."""

from __future__ import annotations

import pytest
import torch

from aeroscene.learning.paper.network.routing import GATE_TEMPERATURE, LearnedRouting, given_routes
from tests.aeroscene.learning.model.trees import tree_batch


def routing() -> tuple[LearnedRouting, torch.Tensor, torch.Tensor]:
    torch.manual_seed(0)
    real = torch.ones(2, 7, dtype=torch.bool)
    real[1, 4:] = False
    return LearnedRouting(16), 3 * torch.randn(2, 7, 16), real


def test_tokenizability_is_the_equation() -> None:
    gate, feature, real = routing()
    tau = gate(feature, real).tokenizability
    hidden = torch.nn.functional.silu(feature @ gate.mlp[0].weight.T + gate.mlp[0].bias)
    score = (hidden @ gate.mlp[2].weight.T + gate.mlp[2].bias) @ gate.w_tau.weight[0]
    torch.testing.assert_close(tau, torch.sigmoid(score) * real)


def test_tokens_below_gamma_are_coarse_and_the_others_fine() -> None:
    gate, feature, real = routing()
    routes = gate(feature, real)
    below = routes.tokenizability < gate.gamma
    assert below[real].any()
    assert not below[real].all()
    assert torch.equal(routes.is_coarse, below & real)
    assert torch.equal(routes.is_fine, ~below & real)
    torch.testing.assert_close(routes.coarse_weight.squeeze(-1), routes.is_coarse.float())
    torch.testing.assert_close(routes.fine_weight.squeeze(-1), routes.is_fine.float())


def test_gamma_gets_the_gradient_of_the_soft_gate() -> None:
    gate, feature, real = routing()
    routes = gate(feature, real)
    routes.fine_weight.sum().backward()
    soft = torch.sigmoid((routes.tokenizability - gate.gamma) / GATE_TEMPERATURE)[real]
    expected = -(soft * (1 - soft)).sum() / GATE_TEMPERATURE
    assert gate.gamma.grad == pytest.approx(expected.item(), rel=1e-5)
    assert gate.w_tau.weight.grad.abs().sum() > 0


def test_gamma_learns_to_part_scores_that_lie_on_one_side_of_it() -> None:
    gate, feature, real = routing()
    with torch.no_grad():
        tau = gate(feature, real).tokenizability
        wanted = (tau > tau[real].median()) & real
        gate.gamma.fill_(0.9)
        assert not gate(feature, real).is_fine.any()
    optimiser = torch.optim.SGD([gate.gamma], lr=0.002)
    for _ in range(120):
        routes = gate(feature, real)
        loss = (routes.fine_weight.squeeze(-1) - wanted.float()).square().sum()
        optimiser.zero_grad()
        loss.backward()
        optimiser.step()
    assert (routes.is_fine != wanted).sum() <= 1


def test_given_routes_are_the_slots() -> None:
    routes = given_routes(tree_batch([(3, 4), (2, 5)], (4, 6)))
    assert routes.is_coarse.sum(1).tolist() == [3, 2]
    assert routes.is_fine.sum(1).tolist() == [4, 5]
    assert not routes.is_coarse[:, 4:].any()
    assert not routes.is_fine[:, :4].any()
    assert routes.tokenizability is None
