"""DiffuScene: denoising diffusion over the flat set of all objects with all their attributes.

This is a re-implementation from the paper, without its shape codes, because our objects have none.

    choice      paper                                                    here
    network     1-D UNet with attention over the set                     the same, narrower
    slots       told apart by a learned embedding                        the same
    predicts    noise of place, size, angle and category together        the same
    categories  one-hot with "empty"                                     the same, -1 and 1
    loss        L_sce + 0.1 L_iou of the clean layout, by alpha_bar      the same
    L_sce       a mean for geometry and one for categories               the same
    steps       1,000                                                    `BaselineCfg.steps`

Source: Tang, Nie, Markhasin, Dai, Thies and Niessner 2024, "DiffuScene: Denoising Diffusion Models
for Generative Indoor Scene Synthesis", CVPR, sections 3.1 to 3.3.
"""

from __future__ import annotations

from dataclasses import replace

import torch
from torch import Tensor

from aeroscene.learning.baselines.layouts import (
    CATEGORY,
    CENTRE,
    EMPTY,
    HEADING,
    LOG_SIZE,
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
from aeroscene.learning.diffusion.sampling import Guidance, sample
from aeroscene.learning.diffusion.schedule import Schedule
from aeroscene.learning.paper.boxes import FlatBoxes
from aeroscene.learning.paper.guidance.collision import collision_loss
from aeroscene.learning.paper.guidance.layout import Layout
from aeroscene.learning.training.loop import LossTerms
from aeroscene.metrics.arrays import IS_COARSE

_LOSS = LossCfg(parameterisation="eps", is_stratified=False, guide_weight=0.1, guide_scenes=4)
"""The overlap is computed for `guide_scenes` scenes of a batch only: it takes longer than the
rest."""
# Every overlap counts, and its edge is softened over 0.1 m so that it has a gradient.
_IOU_TOLERANCE = 0.0
_SOFTNESS_M = 0.1


class DiffuScene(BaselineModel):
    """The denoiser with its loss and its sampler."""

    def __init__(self, code: LayoutCode, cfg: BaselineCfg) -> None:
        super().__init__(code)
        self.denoiser = SetUnet(N_CHANNELS, code.n_slots, cfg.width, cfg.levels, cfg.heads)
        self._schedule = Schedule(ScheduleCfg(kind="linear"))
        self._sampler = SamplerCfg(kind="ddpm", n_steps=cfg.steps, parameterisation="eps")
        self.read = LayoutReader(code)

    def forward(self, batch: TokenBatch, generator: torch.Generator) -> LossTerms:
        """L_sce + 0.1 L_iou of a batch at random times."""
        assert batch.weight is not None
        # Geometry and categories count alike, although there are ten times
        # as many category channels.
        weight = batch.weight.clone()
        weight[..., N_GEOMETRY:] *= N_GEOMETRY / (N_CHANNELS - N_GEOMETRY)
        batch = replace(batch, weight=weight)
        return vars(
            diffusion_loss(self.denoiser, batch, self._schedule, _LOSS, generator, self._overlap)
        )

    def draw(self, domain: int, generator: torch.Generator) -> FlatBoxes:
        """Draw a layout by ancestral sampling with `BaselineCfg.steps` steps."""
        device = next(self.parameters()).device
        bounds = [torch.as_tensor(b, dtype=torch.float32) for b in (self.code.low, self.code.high)]
        x0 = sample(
            self.denoiser,
            empty_batch([domain], self.code.n_slots).to(device),
            self._schedule,
            self._sampler,
            generator,
            guidance=self.guidance,
            x0_range=(bounds[0].to(device), bounds[1].to(device)),
        )
        return self.code.decode(x0[0].double().cpu().numpy())

    @property
    def guidance(self) -> Guidance | None:
        """Guidance of the sampling; None here, and the point in which PhyScene differs."""
        return None

    def _overlap(self, x0: Tensor, batch: TokenBatch) -> Tensor:
        layout = self.read(x0, batch)
        return collision_loss(layout, tolerance=_IOU_TOLERANCE, kind="soft", softness_m=_SOFTNESS_M)


class LayoutReader:
    """Reads channels as objects in the world, differentiably.

    The result is a `Layout`, on which the paper's collision loss is evaluated.
    """

    def __init__(self, code: LayoutCode) -> None:
        self._mean = torch.as_tensor(code.mean, dtype=torch.float32)
        self._spread = torch.as_tensor(code.spread, dtype=torch.float32)
        self._low = torch.as_tensor(code.low[:6], dtype=torch.float32)
        self._high = torch.as_tensor(code.high[:6], dtype=torch.float32)
        self.spread_m = float(code.spread[:2].max())
        """Length of one unit of a standardised place."""

    def __call__(self, x: Tensor, batch: TokenBatch) -> Layout:
        """Return the layout; empty slots are masked out."""
        del batch
        # Sizes are exponentials: without this limit an early, noisy x0 would have endless boxes.
        kept = torch.minimum(torch.maximum(x[..., :6], self._low.to(x)), self._high.to(x))
        rows = kept * self._spread.to(x) + self._mean.to(x)
        heading = x[..., HEADING]
        category = x[..., CATEGORY].detach()
        likely = category.argmax(dim=-1)
        return Layout(
            rows[..., CENTRE],
            # The norm may be 0 in noise.
            heading / heading.norm(dim=-1, keepdim=True).clamp(min=1e-6),
            rows[..., LOG_SIZE].exp(),
            1 + likely,
            category.amax(dim=-1) > x[..., EMPTY].detach(),
            # The levels are those of the first scene. Nothing reads them where
            # there are several scenes.
            torch.from_numpy(IS_COARSE).to(x.device)[likely[0]],
        )
