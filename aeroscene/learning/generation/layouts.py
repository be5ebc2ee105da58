"""The paper's algorithm 2: from a wish to a layout of boxes.

The list of objects comes first, from the contents model. Diffusion then draws their boxes. The
`progressive` preset has two passes: coarse objects, then fine ones given the coarse ones. The
`paper` preset has one pass for all.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import torch
from torch import Tensor

from aeroscene.learning.batch import TokenBatch
from aeroscene.learning.diffusion.config import SamplerCfg
from aeroscene.learning.diffusion.loss import Denoiser
from aeroscene.learning.diffusion.sampling import Guidance, Moment, sample
from aeroscene.learning.diffusion.schedule import Schedule
from aeroscene.learning.generation.proposal import OnStep, noise_of
from aeroscene.learning.generation.request import NO_THEMES, Request, RequestError, Themes
from aeroscene.learning.paper.boxes import FlatBoxes
from aeroscene.learning.paper.channels import N_GEOMETRY, FlatStatistics
from aeroscene.learning.paper.contents.model import ContentsModel
from aeroscene.learning.paper.contents.sentences import Contents
from aeroscene.learning.paper.guidance.layout import FlatReader, Layout
from aeroscene.learning.paper.layouts import FlatLayout
from aeroscene.learning.paper.looks import Looks
from aeroscene.learning.paper.training_set import Row, batch_of, row_of
from aeroscene.learning.wishes import Wish
from aeroscene.scene import DOMAINS, Scene, SceneDomain

_MOST = 8.0
"""A prediction is clipped at so many spreads: one object of 300 km spoils a scene."""


@dataclass(frozen=True)
class FlatProposal:
    """Boxes of a flat layout, not yet with looks."""

    boxes: FlatBoxes
    domain: SceneDomain
    looks: Looks

    def scene(self, scene_id: str, seed: int, rng: np.random.Generator) -> Scene:
        """Build the scene as sampled, without areas; `rng` draws the looks.

        Raises:
            SceneError: If a number is not finite.
        """
        return self.boxes.scene(self.domain, self.looks, scene_id, seed, rng)


@dataclass(frozen=True, kw_only=True)
class FlatModel:
    """Parts of a checkpoint that draw flat layouts."""

    contents: ContentsModel
    denoiser: Denoiser
    looks: Looks
    statistics: FlatStatistics
    schedule: Schedule
    sampler: SamplerCfg
    guidance: Guidance
    device: torch.device


class FlatProposer:
    """Draws contents from their prior, then geometry by diffusion, in one pass or two."""

    def __init__(self, model: FlatModel) -> None:
        self._model = model
        self._read = FlatReader(model.statistics, model.device)
        self._is_usable = model.looks.is_known
        limit = torch.tensor(_MOST, device=model.device)
        self._x0_range = (-limit, limit)

    @property
    def themes(self) -> Themes:
        """No themes: the paper's layouts do not name the kind of place."""
        return NO_THEMES

    def propose(
        self,
        requests: Sequence[Request],
        wishes: Sequence[Wish],
        rngs: Sequence[np.random.Generator],
        on_step: OnStep | None = None,
    ) -> list[FlatProposal]:
        """Draw layouts of about as many objects as wished for.

        Args:
            requests: Requests, without outlines and without given scenes.
            wishes: Contents of each layout.
            rngs: Source of each layout's contents; the first one also seeds the noise.
            on_step: Called at every step with the noisy layouts.

        Raises:
            RequestError: If an outline or a scene is given: the paper has neither.
        """
        for request in requests:
            if request.given is not None or request.outline_m is not None:
                raise RequestError(
                    "an outline or a scene is given with the paper's preset; valid: neither; "
                    "--preset default takes them"
                )
        model = self._model
        blanks = [
            _blank(self._contents(wish, rng), wish, self._site_yaw_rad(wish, rng))
            for wish, rng in zip(wishes, rngs, strict=True)
        ]
        layouts, turns = [layout for layout, _ in blanks], [turn for _, turn in blanks]
        noise = noise_of(rngs, model.device)
        # False is the first pass, of coarse objects; the paper's preset has the second only.
        passes = (False, True) if model.statistics.has_regions else (True,)
        for is_second in passes:
            rows = [
                _row(layout, turn, model.statistics, is_second=is_second)
                for layout, turn in zip(layouts, turns, strict=True)
            ]
            # A pass in which every object is given has nothing to draw: a
            # scene without fine objects.
            if all(row.n == row.is_given * row.layout.n_coarse for row in rows):
                continue
            layouts = self._sampled(rows, noise, on_step)
        return [self._proposal(layout) for layout in layouts]

    def _contents(self, wish: Wish, rng: np.random.Generator) -> Contents:
        model = self._model
        generator = noise_of([rng], model.device)
        return model.contents.draw(wish, model.statistics, self._is_usable, generator)

    def _site_yaw_rad(self, wish: Wish, rng: np.random.Generator) -> float:
        known = self._model.statistics.site_yaw_rad
        return float(rng.choice(known[DOMAINS.index(wish.domain)]))

    def _sampled(
        self, rows: Sequence[Row], noise: torch.Generator, on_step: OnStep | None
    ) -> list[FlatLayout]:
        """Draw the geometry of all objects of the rows that are not given."""
        model = self._model
        batch = batch_of(rows, model.statistics).to(model.device)

        def watch(moment: Moment, x_t: Tensor, x0: Tensor) -> None:
            del x0
            if on_step is not None:
                shown = self._placed(x_t, batch, rows)
                cut = (_cut(*each) for each in zip(shown, rows, strict=True))
                on_step(moment, [self._proposal(layout) for layout in cut])

        x0 = sample(
            model.denoiser,
            batch,
            model.schedule,
            model.sampler,
            noise,
            guidance=model.guidance,
            x0_range=self._x0_range,
            on_step=watch,
        )
        return self._placed(x0, batch, rows)

    def _placed(self, x: Tensor, batch: TokenBatch, rows: Sequence[Row]) -> list[FlatLayout]:
        boxes: Layout = self._read(x.double(), batch)
        center, size = boxes.center_enu_m.cpu().numpy(), boxes.size_m.cpu().numpy()
        yaw = torch.atan2(boxes.heading[..., 1], boxes.heading[..., 0]).cpu().numpy()
        found = []
        for i, row in enumerate(rows):
            slots = np.flatnonzero(batch.mask[i].cpu().numpy())
            layout = row.layout
            news = [
                values.copy() for values in (layout.center_enu_m, layout.yaw_rad, layout.size_m)
            ]
            for new, values in zip(news, (center, yaw, size), strict=True):
                # The batch has padded slots; a layout has none.
                new[: row.n] = values[i, slots]
            found.append(replace(layout, center_enu_m=news[0], yaw_rad=news[1], size_m=news[2]))
        return found

    def _proposal(self, layout: FlatLayout) -> FlatProposal:
        model = self._model
        boxes = FlatBoxes(
            layout.category,
            layout.center_enu_m,
            layout.yaw_rad,
            layout.size_m,
            layout.region if model.statistics.has_regions else None,
        )
        return FlatProposal(boxes.turned(layout.site_yaw_rad), layout.wish.domain, model.looks)


def _blank(contents: Contents, wish: Wish, site_yaw_rad: float) -> tuple[FlatLayout, np.ndarray]:
    """Return contents as a layout without geometry, and their quarter turns."""
    n = len(contents.category)
    layout = FlatLayout(
        category=contents.category,
        center_enu_m=np.zeros((n, 3)),
        yaw_rad=np.zeros(n),
        size_m=np.ones((n, 3)),
        region=contents.region,
        n_coarse=contents.n_coarse,
        half_m=np.array(contents.half_m),
        site_yaw_rad=site_yaw_rad,
        wish=wish,
    )
    return layout, contents.turn


def _row(
    layout: FlatLayout, turn: np.ndarray, statistics: FlatStatistics, *, is_second: bool
) -> Row:
    """Return a row without geometry, but for the objects that are given."""
    row = row_of(layout, statistics, is_second=is_second)
    n_known = layout.n_coarse if row.is_given else 0
    x0, turns = np.zeros((len(layout), N_GEOMETRY)), turn.copy()
    x0[:n_known], turns[:n_known] = row.x0[:n_known], row.turn[:n_known]
    return replace(row, x0=x0, turn=turns)


def _cut(layout: FlatLayout, row: Row) -> FlatLayout:
    """Return only the objects that a row shows."""
    return replace(
        layout,
        category=layout.category[: row.n],
        center_enu_m=layout.center_enu_m[: row.n],
        yaw_rad=layout.yaw_rad[: row.n],
        size_m=layout.size_m[: row.n],
        region=layout.region[: row.n],
    )
