"""Fine branch: F_fine = GNN_fine(T_fine, G_fine) over the radius graph."""

from __future__ import annotations

import torch
from jaxtyping import Bool, Float
from torch import Tensor, nn


def radius_graph(
    position: Float[Tensor, "batch n 3"], is_fine: Bool[Tensor, "batch n"], radius: float
) -> Bool[Tensor, "batch n n"]:
    """Spatial adjacency G_fine: pairs of fine tokens at a Euclidean distance <= delta_f.

    The adjacency is symmetric, without loops.

    Args:
        position: Positions of all tokens.
        is_fine: True for fine tokens.
        radius: delta_f, in the unit of the positions.
    """
    distance = (position.unsqueeze(2) - position.unsqueeze(1)).float().square().sum(-1)
    near = distance <= radius**2
    others = ~torch.eye(position.shape[1], dtype=torch.bool, device=position.device)
    return near & is_fine.unsqueeze(1) & is_fine.unsqueeze(2) & others


class GnnLayer(nn.Module):
    """f_i <- MLP(f_i || sum over neighbours j of MLP(f_j)), the paper's node update."""

    def __init__(self, width: int) -> None:
        super().__init__()
        self.message = nn.Sequential(nn.Linear(width, width), nn.SiLU(), nn.Linear(width, width))
        self.update = nn.Sequential(nn.Linear(2 * width, width), nn.SiLU(), nn.Linear(width, width))

    def forward(
        self, feature: Float[Tensor, "batch n d"], adjacency: Float[Tensor, "batch n n"]
    ) -> Float[Tensor, "batch n d"]:
        """Update all nodes."""
        summed = adjacency @ self.message(feature)
        return self.update(torch.cat([feature, summed], dim=-1))


class FineGnn(nn.Module):
    """Two layers of `GnnLayer` over the radius graph."""

    def __init__(self, width: int, radius: float) -> None:
        super().__init__()
        self.radius = radius
        self.layers = nn.ModuleList([GnnLayer(width), GnnLayer(width)])

    def forward(
        self,
        token: Float[Tensor, "batch n d"],
        is_fine: Bool[Tensor, "batch n"],
        position: Float[Tensor, "batch n 3"],
    ) -> Float[Tensor, "batch n d"]:
        """Return features of all tokens; the fine ones are the graph's nodes.

        Args:
            token: Features of all tokens.
            is_fine: True for the nodes of the graph.
            position: Positions in the unit of the radius.
        """
        adjacency = radius_graph(position, is_fine, self.radius).to(token.dtype)
        for layer in self.layers:
            token = layer(token, adjacency)
        return token
