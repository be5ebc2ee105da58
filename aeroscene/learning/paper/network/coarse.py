"""Coarse branch: F_coarse = CNN_coarse(T_coarse) over a voxel grid.

Tokens are no image, so the 3D CNN needs a grid. Features are splatted to the eight voxels around
each position, convolved there, and gathered back at the same positions. Both directions are
products with one matrix of trilinear weights. At these sizes that is no slower than indexed sums,
and unlike these it gives the same result every time on a GPU.
"""

from __future__ import annotations

import math

import torch
from jaxtyping import Bool, Float
from torch import Tensor, nn
from torch.nn import functional


def trilinear_weights(
    position: Float[Tensor, "batch n 3"], shape: tuple[int, int, int], reach: float
) -> Float[Tensor, "batch n voxels"]:
    """Return the share of each position at each voxel of a grid.

    Args:
        position: Positions in channel units; those beyond the grid count as on its border.
        shape: Voxels along x, y and z, at least two.
        reach: Distance in channel units from the middle to the outermost voxel centres.

    Returns:
        Weights of the voxels, x slowest; the sum of each row is 1.
    """
    last = torch.tensor(shape, device=position.device) - 1
    place = ((position.float() / reach).clamp(-1.0, 1.0) + 1.0) / 2.0 * last
    # At the last voxel the lower neighbour is the one before, so that both exist.
    low = torch.minimum(place.floor(), last - 1.0)
    part = place - low
    shares = torch.zeros(*position.shape[:2], math.prod(shape), device=position.device)
    for corner in range(8):
        bit = torch.tensor([corner >> 2, corner >> 1 & 1, corner & 1], device=position.device)
        x, y, z = (low.long() + bit).unbind(-1)
        voxel = (x * shape[1] + y) * shape[2] + z
        share = torch.where(bit.bool(), part, 1.0 - part).prod(-1)
        shares.scatter_(2, voxel.unsqueeze(-1), share.unsqueeze(-1))
    return shares


def splat_mean(
    feature: Float[Tensor, "batch n c"],
    is_there: Bool[Tensor, "batch n"],
    shares: Float[Tensor, "batch n voxels"],
) -> tuple[Float[Tensor, "batch voxels c"], Float[Tensor, "batch voxels 1"]]:
    """Return the mean of the features at each voxel, and the number of tokens there.

    A token that shares its voxels with no other is gathered back unchanged.
    """
    weight = is_there.unsqueeze(-1).to(feature.dtype)
    total = shares.transpose(1, 2) @ torch.cat([feature * weight, weight], -1)
    amount = total[..., -1:]
    return total[..., :-1] / amount.clamp_min(1e-6), amount


class CoarseCnn(nn.Module):
    """Lightweight 3D CNN over the coarse tokens of a layout.

    Args:
        width: Width of a token.
        channels: Width of the features on the grid.
        shape: Voxels along x, y and z.
        reach: Half of the grid's extent, in channel units.
    """

    def __init__(
        self, width: int, channels: int, shape: tuple[int, int, int], reach: float
    ) -> None:
        super().__init__()
        self.shape, self.reach = shape, reach
        self.inward = nn.Linear(width, channels)
        # One more channel holds the number of tokens: the mean alone cannot tell empty from zero.
        self.first = nn.Conv3d(channels + 1, channels, 3, padding=1)
        self.second = nn.Conv3d(channels, channels, 3, padding=1)
        self.outward = nn.Linear(channels, width)

    def forward(
        self,
        token: Float[Tensor, "batch n d"],
        is_coarse: Bool[Tensor, "batch n"],
        position: Float[Tensor, "batch n 3"],
    ) -> Float[Tensor, "batch n d"]:
        """Return features of all tokens; the grid holds the coarse ones.

        Args:
            token: Features of all tokens.
            is_coarse: True for tokens that are splatted to the grid.
            position: Positions in channel units.
        """
        shares = trilinear_weights(position, self.shape, self.reach)
        mean, amount = splat_mean(self.inward(token), is_coarse, shares)
        grid = torch.cat([mean, amount], -1).transpose(1, 2).unflatten(2, self.shape)
        grid = self.second(functional.silu(self.first(grid)))
        found = shares @ grid.flatten(2).transpose(1, 2)
        return token + self.outward(functional.silu(found))
