"""Training scenes as flat layouts, and the batches that are made of them.

A batch pads its scenes to one length, so scenes of very different sizes waste most of it. Batches
are therefore drawn from scenes with similar numbers of objects. In the progressive preset some
batches teach the first pass (coarse objects alone), and the others the second (fine objects, given
the coarse ones).
"""

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
"""Share of the progressive batches that teach the first pass."""
_POOL = 2
"""A batch is drawn from so many times its size of scenes with similar numbers of objects."""
_WEIGHT = np.array([1.0, 1.0, *[0.5] * 8], dtype=np.float32)
"""Weight of an error of each channel: places count most, because everything else depends on
them."""


@dataclass(frozen=True, eq=False)
class FlatTrainingSet:
    """Training scenes as flat layouts, which it serves in batches."""

    looks: Looks
    statistics: FlatStatistics
    examples: tuple[FlatLayout, ...]

    @property
    def known(self) -> FlatStatistics:
        """Statistics of the scenes, which a checkpoint keeps beside their kinds."""
        return self.statistics

    @property
    def kinds_json(self) -> str:
        """Looks of objects as text."""
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
        """Function that turns another scene and its wish into an example.

        It does not hold the examples, so it can be sent to another process cheaply.
        """
        return partial(flat_layout, has_regions=bool(self.statistics.has_regions))

    def with_examples(self, examples: Sequence[FlatLayout]) -> FlatTrainingSet:
        """Return a set of other scenes with the statistics of this one."""
        return replace(self, examples=tuple(examples))

    def sample_batch(self, size: int, rng: np.random.Generator) -> TokenBatch:
        """Draw scenes with similar numbers of objects.

        Each is turned at random, and mirrored at random indoors.
        """
        # A whole batch belongs to one pass, because their numbers of slots differ.
        is_second = not self.statistics.has_regions or rng.random() >= COARSE_PASS_SHARE
        chosen = self.alike(size, rng, coarse_only=not is_second)
        layouts = [random_symmetry(each, rng) for each in chosen]
        return self._batch(layouts, [is_second] * size)

    def alike(
        self, size: int, rng: np.random.Generator, *, coarse_only: bool = False
    ) -> list[FlatLayout]:
        """Draw scenes near one that is drawn evenly, by their number of objects.

        Args:
            size: Number of scenes.
            rng: Source of the draw.
            coarse_only: True counts coarse objects alone.
        """
        pool = _near(self._by_coarse if coarse_only else self._by_count, _POOL * size, rng)
        # Coarse and fine slots are padded separately, so both numbers should be similar.
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
        """Return scenes as they are, for measuring.

        Progressive scenes take turns: one in the first pass, the next in the second.
        """
        layouts = self.examples[start : start + size]
        return self._batch(layouts, [(start + i) % 2 == 0 for i in range(len(layouts))])

    def in_pass(self, *, is_second: bool) -> TokenBatch:
        """Return all scenes as they are, in one of the two passes of the progressive preset."""
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
    """Return up to `most` neighbouring rows about one that is drawn evenly."""
    n = len(rows)
    width = min(n, most)
    start = int(np.clip(rng.integers(n) - width // 2, 0, n - width))
    return rows[start : start + width]


def flat_training_set(scenes: Sequence[Scene], *, has_regions: bool = False) -> FlatTrainingSet:
    """Turn scenes into a training set and measure its statistics.

    Args:
        scenes: At least one scene.
        has_regions: True for the progressive preset, which places fine objects in their regions.
    """
    # Statistics need regions for either preset: they record which categories hold fine objects.
    layouts = [flat_layout(scene, Wish.from_scene(scene), has_regions=True) for scene in scenes]
    statistics = measure(layouts, has_regions=has_regions)
    if not has_regions:
        layouts = [
            flat_layout(scene, Wish.from_scene(scene), has_regions=False) for scene in scenes
        ]
    return FlatTrainingSet(Looks.from_scenes(scenes), statistics, tuple(layouts))


@dataclass(frozen=True, eq=False)
class Row:
    """One scene of a batch."""

    layout: FlatLayout
    """Objects of the scene. Only category, region, number of coarse objects and wish are read."""
    n: int
    """Number of objects that are shown, from the first on."""
    frame: Float[np.ndarray, "m 7"]
    """Frame of each object, as `Frames.packed`."""
    x0: Float[np.ndarray, "m 10"]
    """Standardised channels."""
    turn: Int[np.ndarray, " m"]
    """Quarter turn of each object."""
    is_given: bool
    """True if the coarse objects are given."""


def row_of(layout: FlatLayout, statistics: FlatStatistics, *, is_second: bool = True) -> Row:
    """Return a layout with its channels.

    If the statistics have regions, the first pass shows the coarse objects alone, and the second
    all objects with the coarse ones given. Without regions all objects are shown and none is given.

    Args:
        layout: The layout.
        statistics: Statistics of the training scenes.
        is_second: True for the second pass.
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
    """Pack scenes into a batch: coarse slots first, then fine ones, each padded at its end.

    Channels in which all objects of a category agree have no weight: they stay at their mean.
    """
    variance = statistics.variance
    n_coarse = max(row.layout.n_coarse for row in rows)
    n_fine = max(row.n - row.layout.n_coarse for row in rows)
    shape = (len(rows), n_coarse + n_fine)
    x0 = np.zeros((*shape, N_GEOMETRY), dtype=np.float32)
    # Padding has a unit frame at the origin: its half extents are divided by.
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
        # All objects of the layout count here, shown or not: a room is made for its furniture.
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
