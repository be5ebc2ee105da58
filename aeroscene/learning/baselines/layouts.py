"""Scenes as flat layouts, the form that all baselines learn: a set of boxes with categories.

    channels  name                                        unit
    0, 1, 2   centre, along the axes of the site and up   standardised
    3, 4, 5   logarithms of full extents                  standardised
    6, 7      cosine and sine of the yaw                  -
    8 to 77   category, one-hot                           -1 or 1
    78        no object                                   -1 or 1

A layout has as many slots as the largest training scene has objects; the other slots say that they
are empty. Tilts are left out: 13 of 24,563 objects of 3D-FRONT tilt. Order and frame of the objects
are those of the paper's presets (`aeroscene.learning.paper.layouts`), so that a choice that helped
our own method also helps the methods that it is compared with.

Source: Tang et al. 2024, "DiffuScene", section 3.1, the object attributes. Sizes are logarithms
here, because ours go from a cup to a building.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np
import torch
from jaxtyping import Float

from aeroscene.learning.batch import TokenBatch
from aeroscene.learning.paper.boxes import FlatBoxes
from aeroscene.learning.paper.channels import site_yaw_quantiles_rad
from aeroscene.learning.paper.layouts import FlatLayout, flat_layout, random_symmetry
from aeroscene.learning.paper.looks import Looks
from aeroscene.learning.wishes import Wish
from aeroscene.metrics.arrays import N_CATEGORIES
from aeroscene.scene import DOMAINS, Scene, SceneDomain

CENTRE, LOG_SIZE, HEADING = slice(0, 3), slice(3, 6), slice(6, 8)
N_GEOMETRY = 8
CATEGORY = slice(N_GEOMETRY, N_GEOMETRY + N_CATEGORIES)
EMPTY = N_GEOMETRY + N_CATEGORIES
N_CHANNELS = EMPTY + 1
# A channel that never varies in training would otherwise be divided by zero.
_LEAST_SPREAD = 1e-3
# The number of slots is rounded up to a multiple of this.
_SLOT_STEP = 8


def layouts_of(scenes: Sequence[Scene]) -> tuple[FlatLayout, ...]:
    """Turn scenes into the axes of their sites, as lists in one fixed order."""
    return tuple(flat_layout(scene, Wish.from_scene(scene), has_regions=True) for scene in scenes)


@dataclass(frozen=True, eq=False)
class LayoutCode:
    """Conversion between boxes and channels, with scales measured on training scenes."""

    n_slots: int
    mean: Float[np.ndarray, " 6"]
    """Mean of channels 0 to 5 before standardising; m, and logarithms of m."""
    spread: Float[np.ndarray, " 6"]
    """Standard deviation of channels 0 to 5; x and y share one."""
    low: Float[np.ndarray, " 79"]
    """Least value of each channel in training, after standardising."""
    high: Float[np.ndarray, " 79"]
    """Greatest value of each channel in training, after standardising."""
    looks: Looks
    site_yaw_rad: Float[np.ndarray, "domains quantiles"]
    """Quantiles of the yaw of training sites; a new site draws its yaw among these."""

    @classmethod
    def from_scenes(cls, scenes: Sequence[Scene]) -> Self:
        """Measure training scenes, as if every quarter turn and mirror image of them were there.

        Args:
            scenes: At least one scene.
        """
        layouts = layouts_of(scenes)
        rows = np.concatenate([_measures(layout) for layout in layouts])
        mean, spread = rows.mean(axis=0), np.maximum(rows.std(axis=0), _LEAST_SPREAD)
        # Under quarter turns east and north have mean 0 and one common spread.
        mean[:2] = 0.0
        spread[:2] = max(float(np.sqrt((rows[:, :2] ** 2).mean())), _LEAST_SPREAD)
        coded = (rows - mean) / spread
        low, high = -np.ones(N_CHANNELS), np.ones(N_CHANNELS)
        low[:6], high[:6] = coded.min(axis=0), coded.max(axis=0)
        high[:2] = np.abs(coded[:, :2]).max()
        low[:2] = -high[:2]
        # Empty slots have zeros.
        low[:6], high[:6] = np.minimum(low[:6], 0.0), np.maximum(high[:6], 0.0)
        most = max(len(layout) for layout in layouts)
        n_slots = -(-most // _SLOT_STEP) * _SLOT_STEP
        site_yaw_rad = site_yaw_quantiles_rad(layouts)
        return cls(n_slots, mean, spread, low, high, Looks.from_scenes(scenes), site_yaw_rad)

    def encode(self, boxes: FlatBoxes | FlatLayout) -> Float[np.ndarray, "n 79"]:
        """Return the channels of the objects, without empty slots."""
        n = len(boxes.category)
        x = np.full((n, N_CHANNELS), -1.0)
        x[:, :6] = (_measures(boxes) - self.mean) / self.spread
        x[:, 6], x[:, 7] = np.cos(boxes.yaw_rad), np.sin(boxes.yaw_rad)
        # Categories count from 1 in a layout; 0 is the empty category.
        x[np.arange(n), N_GEOMETRY - 1 + boxes.category] = 1.0
        return x

    def decode(self, x: Float[np.ndarray, "n 79"]) -> FlatBoxes:
        """Return the boxes of those slots that hold an object.

        If every slot says that it is empty, the likeliest one counts, because a scene needs an
        object. Places and sizes are clipped to the range of training.
        """
        is_there = x[:, CATEGORY].max(axis=1) > x[:, EMPTY]
        if not is_there.any():
            is_there[(x[:, CATEGORY].max(axis=1) - x[:, EMPTY]).argmax()] = True
        x = x[is_there]
        rows = np.clip(x[:, :6], self.low[:6], self.high[:6]) * self.spread + self.mean
        return FlatBoxes(
            category=1 + x[:, CATEGORY].argmax(axis=1),
            center_enu_m=rows[:, CENTRE],
            yaw_rad=np.arctan2(x[:, 7], x[:, 6]),
            size_m=np.exp(rows[:, LOG_SIZE]),
        )

    def scene(
        self, boxes: FlatBoxes, domain: SceneDomain, seed: int, rng: np.random.Generator
    ) -> Scene:
        """Build a scene from boxes, without landing areas, as the paper's flat layouts are read.

        A fine object becomes a child of the nearest coarse object.

        Args:
            boxes: Boxes in the axes of the site.
            domain: Domain of the scene.
            seed: Seed that the scene is named after.
            rng: Draws the yaw of the site, the kinds within categories, and the looks.

        Raises:
            SceneError: If a number is not finite.
        """
        site_yaw_rad = float(rng.choice(self.site_yaw_rad[DOMAINS.index(domain)]))
        turned = boxes.turned(site_yaw_rad)
        return turned.scene(domain, self.looks, f"scene-{seed:04d}", seed, rng)


def _measures(boxes: FlatBoxes | FlatLayout) -> Float[np.ndarray, "n 6"]:
    return np.hstack([boxes.center_enu_m, np.log(boxes.size_m)])


@dataclass(frozen=True, eq=False)
class LayoutSet:
    """Training scenes as flat layouts, which it serves in batches."""

    code: LayoutCode
    examples: tuple[FlatLayout, ...]

    @classmethod
    def from_scenes(cls, scenes: Sequence[Scene], code: LayoutCode) -> Self:
        """Take scenes; those with more objects than there are slots are left out."""
        return cls(code, tuple(each for each in layouts_of(scenes) if len(each) <= code.n_slots))

    @cached_property
    def digest(self) -> str:
        """Sixteen hexadecimal digits that differ between sets of scenes."""
        digest = hashlib.sha256()
        for example in self.examples:
            # Rounded, so that the last bits of another machine's arithmetic
            # do not change the digest.
            digest.update(np.round(self.code.encode(example), 4).astype("<f4").tobytes())
        return digest.hexdigest()[:16]

    def sample_batch(self, size: int, rng: np.random.Generator) -> TokenBatch:
        """Draw scenes with replacement, each turned at random, and mirrored at random indoors."""
        picked = rng.integers(len(self.examples), size=size)
        return self._batch([random_symmetry(self.examples[i], rng) for i in picked])

    def in_order(self, start: int, size: int) -> TokenBatch:
        """Return scenes as they are, for measuring."""
        return self._batch(self.examples[start : start + size])

    def _batch(self, examples: Sequence[FlatLayout]) -> TokenBatch:
        domains = [DOMAINS.index(example.wish.domain) for example in examples]
        batch = empty_batch(domains, self.code.n_slots)
        assert batch.x0 is not None
        for row, example in enumerate(examples):
            n = len(example)
            batch.x0[row, :n] = torch.from_numpy(self.code.encode(example).astype(np.float32))
            batch.mask[row, :n] = True
        return batch


def empty_batch(domains: Sequence[int], n_slots: int) -> TokenBatch:
    """Return slots without objects for some scenes.

    Args:
        domains: Domain of each scene, as its place among `DOMAINS`.
        n_slots: Slots of each scene.

    Returns:
        A batch whose `x0` says "empty" everywhere and whose `mask` is False. Sequence fields are 0:
        flat layouts have no tree.
    """
    shape = (len(domains), n_slots)
    zeros = torch.zeros(shape, dtype=torch.int64)
    x0 = torch.zeros((*shape, N_CHANNELS))
    x0[..., CATEGORY], x0[..., EMPTY] = -1.0, 1.0
    return TokenBatch(
        kind=zeros,
        parent=zeros,
        depth=zeros,
        ordinal=zeros,
        twin=zeros,
        mask=torch.zeros(shape, dtype=torch.bool),
        domain=torch.tensor(list(domains)),
        wish=torch.zeros((len(domains), 3)),
        n_coarse_slots=0,
        x0=x0,
        # Empty slots are learned as well, so they have a weight.
        weight=torch.ones((*shape, N_CHANNELS)),
    )
