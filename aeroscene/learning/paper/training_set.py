"""Training scenes as flat layouts, and the batches that are made of them."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
import torch
from jaxtyping import Float, Int

from aeroscene.learning.batch import TokenBatch, scaled_wish
from aeroscene.learning.paper.channels import (
    N_GEOMETRY,
    N_ROWS,
    FlatStatistics,
    frames_of,
    measure,
    measured_channels,
    standardised,
)
from aeroscene.learning.paper.layouts import NO_REGION, FlatLayout, flat_layout, random_symmetry
from aeroscene.learning.paper.looks import Looks
from aeroscene.learning.wishes import Wish
from aeroscene.scene import DOMAINS, Scene

COARSE_PASS_SHARE = 0.4
"""Share of the progressive batches that show the coarse objects of their scenes alone."""
_POOL = 2
"""A batch is drawn from so many times its size of scenes with about as many objects."""
_WEIGHT = np.array([1.0, 1.0, *[0.5] * 8], dtype=np.float32)
"""What an error of each channel counts: most depends on places."""


@dataclass(frozen=True, eq=False)
class FlatTrainingSet:
    """Scenes as the paper has them, as batches for training."""

    looks: Looks
    statistics: FlatStatistics
    examples: tuple[FlatLayout, ...]

    @property
    def known(self) -> FlatStatistics:
        """What a checkpoint keeps of the scenes, beside their kinds."""
        return self.statistics

    @property
    def kinds_json(self) -> str:
        """The looks of objects as text."""
        return self.looks.to_json()

    @cached_property
    def digest(self) -> str:
        """Sixteen hexadecimal digits that differ between corpora."""
        digest = hashlib.sha256(self.kinds_json.encode())
        for each in self.examples:
            rows = np.column_stack([each.category, each.center_enu_m, each.yaw_rad, each.size_m])
            digest.update(np.round(rows, 4).astype("<f4").tobytes())
        return digest.hexdigest()[:16]

    @property
    def encoder(self) -> Callable[[Scene, Wish], FlatLayout]:
        """From other scenes to examples like these, without these."""
        return partial(flat_layout, has_regions=bool(self.statistics.has_regions))

    def with_examples(self, examples: Sequence[FlatLayout]) -> FlatTrainingSet:
        """Other scenes, standardised as these are."""
        return replace(self, examples=tuple(examples))

    def sample_batch(self, size: int, rng: np.random.Generator) -> TokenBatch:
        """Scenes of about as many objects, each turned at random, indoors mirrored too."""
        is_second = not self.statistics.has_regions or rng.random() >= COARSE_PASS_SHARE
        chosen = self.alike(size, rng, coarse_only=not is_second)
        layouts = [random_symmetry(each, rng) for each in chosen]
        return self._batch(layouts, [is_second] * size)

    def alike(
        self, size: int, rng: np.random.Generator, *, coarse_only: bool = False
    ) -> list[FlatLayout]:
        """Scenes near one that is drawn evenly, by all their objects or the coarse ones alone."""
        pool = _near(self._by_coarse if coarse_only else self._by_count, _POOL * size, rng)
        # Both lists are padded, so both should be about as long as those of the other scenes.
        pool = pool[np.argsort(self._n_coarse[pool], kind="stable")]
        window = _near(pool, size, rng)
        return [self.examples[row] for row in rng.choice(window, size)]

    @cached_property
    def _n_coarse(self) -> Int[np.ndarray, " n"]:
        return np.array([each.n_coarse for each in self.examples])

    @cached_property
    def _by_coarse(self) -> Int[np.ndarray, " n"]:
        return np.argsort(self._n_coarse, kind="stable")

    @cached_property
    def _by_count(self) -> Int[np.ndarray, " n"]:
        return np.argsort([len(each) for each in self.examples], kind="stable")

    def in_order(self, start: int, size: int) -> TokenBatch:
        """Scenes as they are, for measuring; of progressive ones every other its coarse objects."""
        layouts = self.examples[start : start + size]
        return self._batch(layouts, [(start + i) % 2 == 0 for i in range(len(layouts))])

    def in_pass(self, *, is_second: bool) -> TokenBatch:
        """All scenes as they are, in one of the two passes of the progressive preset."""
        return self._batch(self.examples, [is_second] * len(self.examples))

    def _batch(self, layouts: Sequence[FlatLayout], is_second: Sequence[bool]) -> TokenBatch:
        rows = [
            row_of(layout, self.statistics, is_second=second)
            for layout, second in zip(layouts, is_second, strict=True)
        ]
        return batch_of(rows, self.statistics)


def _near(
    rows: Int[np.ndarray, " n"], most: int, rng: np.random.Generator
) -> Int[np.ndarray, " m"]:
    """As many rows beside each other, about one that is drawn evenly."""
    n = len(rows)
    width = min(n, most)
    start = int(np.clip(rng.integers(n) - width // 2, 0, n - width))
    return rows[start : start + width]


def flat_training_set(scenes: Sequence[Scene], *, has_regions: bool = False) -> FlatTrainingSet:
    """The scenes of a corpus and their statistics; `has_regions` is the progressive preset's."""
    layouts = [flat_layout(scene, Wish.of(scene), has_regions=True) for scene in scenes]
    statistics = measure(layouts, has_regions=has_regions)
    if not has_regions:
        layouts = [flat_layout(scene, Wish.of(scene), has_regions=False) for scene in scenes]
    return FlatTrainingSet(Looks.of(scenes), statistics, tuple(layouts))


@dataclass(frozen=True, eq=False)
class Row:
    """One scene of a batch."""

    layout: FlatLayout
    """Its objects; only these are read: category, region, number of coarse ones, wish."""
    n: int
    """Objects that are shown, from the first one on."""
    frame: Float[np.ndarray, "m 7"]
    x0: Float[np.ndarray, "m 10"]
    turn: Int[np.ndarray, " m"]
    is_given: bool
    """Whether the coarse objects are given."""


def row_of(layout: FlatLayout, statistics: FlatStatistics, *, is_second: bool = True) -> Row:
    """A layout with its channels.

    Where the statistics have regions, a scene shows its coarse objects alone, or `is_second`: all,
    with the coarse ones given. Without regions all objects are shown, and none is given.
    """
    has_regions = bool(statistics.has_regions)
    frames = frames_of(layout, statistics)
    channels, turn = measured_channels(layout, frames)
    return Row(
        layout=layout,
        n=len(layout) if is_second or not has_regions else layout.n_coarse,
        frame=frames.packed,
        x0=standardised(channels, layout.category, statistics),
        turn=turn,
        is_given=has_regions and is_second,
    )


def batch_of(rows: Sequence[Row], statistics: FlatStatistics) -> TokenBatch:
    """Scenes as a batch: coarse slots first, then fine ones, each padded at its end.

    Channels in which all objects of a category agree have no weight: they stay as they are.
    """
    variance = statistics.variance
    n_coarse = max(row.layout.n_coarse for row in rows)
    n_fine = max(row.n - row.layout.n_coarse for row in rows)
    shape = (len(rows), n_coarse + n_fine)
    x0 = np.zeros((*shape, N_GEOMETRY), dtype=np.float32)
    frame = np.tile(np.array([0, 0, 0, 1, 0, 1, 1], dtype=np.float32), (*shape, 1))
    kind, turn = np.zeros(shape, dtype=np.int64), np.zeros(shape, dtype=np.int64)
    held = np.zeros((*shape, N_ROWS), dtype=np.float32)
    parent = np.full(shape, NO_REGION, dtype=np.int64)
    mask, given = np.zeros(shape, dtype=bool), np.zeros(shape, dtype=bool)
    for i, row in enumerate(rows):
        layout, n = row.layout, row.n
        n_own = layout.n_coarse
        slots = np.concatenate([np.arange(n_own), n_coarse + np.arange(n - n_own)])
        x0[i, slots], frame[i, slots], turn[i, slots] = row.x0[:n], row.frame[:n], row.turn[:n]
        kind[i, slots], parent[i, slots] = layout.category[:n], layout.region[:n]
        mask[i, slots] = True
        inside = layout.region != NO_REGION
        np.add.at(held[i], (layout.region[inside], layout.category[inside]), 1)
        given[i, :n_own] = row.is_given
    varies = (mask & ~given)[..., None] & (variance[kind] > 0)
    weight = varies * _WEIGHT
    zeros = torch.zeros(shape, dtype=torch.int64)
    wishes = [row.layout.wish for row in rows]
    return TokenBatch(
        kind=torch.from_numpy(kind),
        parent=torch.from_numpy(parent),
        depth=zeros,
        ordinal=zeros,
        twin=zeros,
        mask=torch.from_numpy(mask),
        domain=torch.tensor([DOMAINS.index(wish.domain) for wish in wishes]),
        wish=torch.from_numpy(np.array([scaled_wish(w) for w in wishes], dtype=np.float32)),
        n_coarse_slots=n_coarse,
        x0=torch.from_numpy(x0),
        weight=torch.from_numpy(weight.astype(np.float32)),
        turn=torch.from_numpy(turn),
        frame=torch.from_numpy(frame),
        held=torch.from_numpy(held),
        given=torch.from_numpy(given),
    )
