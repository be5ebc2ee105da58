"""Diffusion-SDF for layouts: a code that signed distances are read from, and diffusion of codes.

This is a re-implementation from the paper, adapted as the AeroScene paper says ("uses a diffusion
model with signed distance fields to model object placements"). Diffusion-SDF codes one shape. Here
the shape is the layout: the distance from a point to the nearest coarse object, and to the nearest
fine one. We need boxes and no surface, so a second decoder reads the objects off the same code.

    choice      paper                                              here
    encoder     PointNet over surface points, variational          attention over objects
    code        one vector, by a linear layer                      the same, of all slots
    modulation  the code conditions an MLP of a point              the same, two distances
    objects     none                                               slots, then attention
    diffusion   of codes, predicts the clean one, trained jointly  the same

Our encoder is variational as well; a linear layer gives the slots from the code.

Source: Chou, Bahat and Heide 2023, "Diffusion-SDF: Conditional Generative Modeling of Signed
Distance Functions", ICCV, sections 3.1 to 3.3.
"""

from __future__ import annotations

from dataclasses import replace

import torch
from jaxtyping import Float
from torch import Tensor, nn
from torch.nn import functional

from aeroscene.learning.baselines.diffuscene import LayoutReader
from aeroscene.learning.baselines.layouts import (
    CATEGORY,
    N_CHANNELS,
    N_GEOMETRY,
    LayoutCode,
    empty_batch,
)
from aeroscene.learning.baselines.model import BaselineCfg, BaselineModel
from aeroscene.learning.baselines.networks.set_unet import SetUnet
from aeroscene.learning.batch import TokenBatch
from aeroscene.learning.diffusion.config import LossCfg, SamplerCfg, ScheduleCfg
from aeroscene.learning.diffusion.loss import diffusion_loss
from aeroscene.learning.diffusion.sampling import sample
from aeroscene.learning.diffusion.schedule import Schedule
from aeroscene.learning.model.encoding import fourier_features
from aeroscene.learning.paper.boxes import FlatBoxes
from aeroscene.learning.paper.network.attention import MaskedAttention
from aeroscene.learning.training.loop import LossTerms
from aeroscene.metrics.arrays import IS_COARSE

_N_CODES, _CODE_WIDTH = 16, 32
"""Number and width of the vectors of a layout's code; the paper has one vector of 768."""
_SHARE_WIDTH = 16
"""Numbers of each slot that go into the code, and that come out of it again."""
_N_POINTS = 64
_NEAR_M = 1.0
"""Half of the points lie about objects, with this standard deviation."""
_MOST_M = 4.0
"""Distances are clipped to this value."""
# Weight of the Kullback-Leibler divergence of codes from the standard normal.
_KL_WEIGHT = 1e-3
_FIRST_LOG_VARIANCE = -4.0
_LOSS = LossCfg(parameterisation="x0", is_stratified=True)
_BANDS = 6


class DiffusionSdf(BaselineModel):
    """Encoder, both decoders, and the denoiser of codes, trained together."""

    def __init__(self, code: LayoutCode, cfg: BaselineCfg) -> None:
        super().__init__(code)
        width, heads = cfg.width, cfg.heads
        half = max(1, cfg.levels // 2)
        self.inward = nn.Linear(N_CHANNELS, width)
        # Geometry gets a layer of its own with large weights: beside seventy categories a
        # coordinate would hardly change the sum.
        self.geometry = nn.Linear(N_GEOMETRY, width)
        nn.init.normal_(self.geometry.weight)
        self.among = nn.ModuleList(_Layer(width, heads) for _ in range(half))
        # One linear layer joins all slots to the code and back. Attention would first have to learn
        # which slot is which.
        n_shares = code.n_slots * _SHARE_WIDTH
        self.to_share = nn.Linear(width, _SHARE_WIDTH)
        self.to_code = nn.Linear(n_shares, 2 * _N_CODES * _CODE_WIDTH)
        with torch.no_grad():
            # A code that starts with variance 1 carries no signal until training has shrunk it.
            self.to_code.bias.unflatten(0, (2, -1))[1].fill_(_FIRST_LOG_VARIANCE)
        self.of_code = nn.Linear(_N_CODES * _CODE_WIDTH, n_shares)
        self.of_share = nn.Linear(_SHARE_WIDTH, width)
        self.slots = nn.Parameter(torch.randn(code.n_slots, width))
        self.between = nn.ModuleList(_Layer(width, heads) for _ in range(half))
        self.outward = nn.Linear(width, N_CHANNELS)
        self.distance = nn.Sequential(
            nn.Linear(_N_CODES * _CODE_WIDTH + 3 * (1 + 2 * _BANDS), width),
            nn.SiLU(),
            nn.Linear(width, width),
            nn.SiLU(),
            nn.Linear(width, 2),
        )
        self.denoiser = SetUnet(_CODE_WIDTH, _N_CODES, width, half, heads)
        self._read = LayoutReader(code)
        self._schedule = Schedule(ScheduleCfg())
        self._sampler = SamplerCfg(kind="ddpm", n_steps=cfg.steps, parameterisation="x0")

    def forward(self, batch: TokenBatch, generator: torch.Generator) -> LossTerms:
        """Sum of the losses of distances, objects, the code's prior, and the denoising of codes.

        Returns:
            `total`, and its four detached parts by name.
        """
        assert batch.x0 is not None
        mean, log_variance = self._encode(batch.x0)
        noise = torch.randn(mean.shape, generator=generator, device=generator.device).to(mean)
        code = mean + (log_variance / 2).exp() * noise
        prior = 0.5 * (mean**2 + log_variance.exp() - 1 - log_variance).mean()
        objects = _object_loss(self._decode(code), batch.x0, batch)
        distances = self._distance_loss(code, batch, generator)
        # Detached: the denoiser learns the codes and does not change the encoder.
        latent = _code_batch(code.detach(), batch.domain)
        codes = diffusion_loss(self.denoiser, latent, self._schedule, _LOSS, generator).total
        total = objects + distances + _KL_WEIGHT * prior + codes
        terms = {"objects": objects, "distances": distances, "prior": prior, "codes": codes}
        return {"total": total} | {name: term.detach() for name, term in terms.items()}

    @torch.no_grad()
    def draw(self, domain: int, generator: torch.Generator) -> FlatBoxes:
        """Denoise a code and read a layout off it."""
        device = next(self.parameters()).device
        blank = torch.zeros((1, _N_CODES, _CODE_WIDTH), device=device)
        batch = _code_batch(blank, torch.tensor([domain], device=device))
        code = sample(self.denoiser, batch, self._schedule, self._sampler, generator)
        return self.code.decode(self._decode(code)[0].double().cpu().numpy())

    def _encode(self, x: Float[Tensor, "batch n c"]) -> tuple[Tensor, Tensor]:
        # The objects are decoded in their order, so the code has to hold the
        # order: slots have vectors.
        place = self.inward(x) + self.geometry(x[..., :N_GEOMETRY]) + self.slots
        for layer in self.among:
            place = layer(place)
        found = self.to_code(self.to_share(place).flatten(1))
        mean, log_variance = found.unflatten(1, (2, _N_CODES, _CODE_WIDTH)).unbind(1)
        # These limits keep the exponential finite.
        return mean, log_variance.clamp(-8.0, 4.0)

    def _decode(self, code: Float[Tensor, "batch k w"]) -> Float[Tensor, "batch n c"]:
        share = self.of_code(code.flatten(1)).unflatten(1, (-1, _SHARE_WIDTH))
        slot = self.slots + self.of_share(share)
        for layer in self.between:
            slot = layer(slot)
        return self.outward(slot)

    def _distance_loss(self, code: Tensor, batch: TokenBatch, generator: torch.Generator) -> Tensor:
        assert batch.x0 is not None
        points_enu_m = self._points(batch, generator)
        true_m = _signed_distances_m(self._read(batch.x0, batch), batch, points_enu_m)
        place = points_enu_m / self._read.spread_m
        place = torch.cat([place, fourier_features(place, _BANDS)], dim=-1)
        flat = code.flatten(1)[:, None].expand(-1, place.shape[1], -1)
        found_m = _MOST_M * self.distance(torch.cat([flat, place], dim=-1))
        return functional.l1_loss(found_m.clamp(-_MOST_M, _MOST_M), true_m) / _MOST_M

    def _points(self, batch: TokenBatch, generator: torch.Generator) -> Float[Tensor, "batch p 3"]:
        """Draw points for the distances: half about objects, half between the outermost ones."""
        assert batch.x0 is not None
        layout = self._read(batch.x0, batch)
        device, n = generator.device, len(batch.mask)
        pick = torch.multinomial(
            batch.mask.float().to(device), _N_POINTS // 2, replacement=True, generator=generator
        )
        noise = torch.randn((n, _N_POINTS // 2, 3), generator=generator, device=device)
        uniform = torch.rand((n, _N_POINTS // 2, 3), generator=generator, device=device)
        centre = layout.center_enu_m
        near = centre.gather(1, pick.to(centre.device)[..., None].expand(-1, -1, 3))
        near = near + _NEAR_M * noise.to(centre)
        hidden = ~batch.mask[..., None]
        low = centre.masked_fill(hidden, torch.inf).amin(1, keepdim=True)
        high = centre.masked_fill(hidden, -torch.inf).amax(1, keepdim=True)
        return torch.cat([near, low + (high - low) * uniform.to(centre)], dim=1)


class _Layer(nn.Module):
    """Attention among places, then a network on each place."""

    def __init__(self, width: int, heads: int) -> None:
        super().__init__()
        self.attention = MaskedAttention(width, heads)
        self.mlp = nn.Sequential(
            nn.LayerNorm(width), nn.Linear(width, 2 * width), nn.SiLU(), nn.Linear(2 * width, width)
        )

    def forward(self, place: Float[Tensor, "batch n d"]) -> Float[Tensor, "batch n d"]:
        place = self.attention(place, place, _all(place))
        return place + self.mlp(place)


def _all(place: Tensor) -> Tensor:
    return torch.ones((1, 1, place.shape[1]), dtype=torch.bool, device=place.device)


def _object_loss(found: Tensor, x0: Tensor, batch: TokenBatch) -> Tensor:
    """Squared error of the geometry of real objects, and cross-entropy of all categories."""
    is_real = batch.mask[..., None]
    squared = ((found - x0)[..., :N_GEOMETRY] ** 2 * is_real).sum()
    geometry = squared / (N_GEOMETRY * is_real.sum()).clamp(min=1)
    label = x0[..., N_GEOMETRY:].argmax(dim=-1)
    logits = found[..., N_GEOMETRY:].flatten(0, 1)
    return geometry + functional.cross_entropy(logits, label.flatten())


def _signed_distances_m(
    layout, batch: TokenBatch, points_enu_m: Float[Tensor, "batch p 3"]
) -> Float[Tensor, "batch p 2"]:
    """Distance from each point to the nearest coarse and the nearest fine box, below 0 inside."""
    assert batch.x0 is not None
    away = points_enu_m[:, :, None] - layout.center_enu_m[:, None]
    cos, sin = layout.heading.unbind(-1)
    cos, sin = cos[:, None], sin[:, None]
    x, y, z = away.unbind(-1)
    local = torch.stack([cos * x + sin * y, cos * y - sin * x, z], dim=-1)
    beyond = local.abs() - layout.size_m[:, None] / 2
    # Outside, the distance to the box; inside, the negative distance to its nearest face.
    outside = beyond.clamp(min=0).norm(dim=-1)
    distance = outside + beyond.amax(dim=-1).clamp(max=0)
    is_coarse = torch.from_numpy(IS_COARSE).to(away.device)[batch.x0[..., CATEGORY].argmax(-1)]
    of_level = [
        # A level without objects is as far away as distances count.
        distance.masked_fill(~(batch.mask & level)[:, None], _MOST_M).amin(dim=-1)
        for level in (is_coarse, ~is_coarse)
    ]
    return torch.stack(of_level, dim=-1).clamp(-_MOST_M, _MOST_M)


def _code_batch(code: Float[Tensor, "batch k w"], domain: Tensor) -> TokenBatch:
    """Wrap codes as tokens, so that the diffusion can read them."""
    batch = empty_batch(domain.tolist(), code.shape[1]).to(code.device)
    return replace(
        batch,
        mask=torch.ones_like(batch.mask),
        x0=code,
        weight=torch.ones_like(code),
    )
