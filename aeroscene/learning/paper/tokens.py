"""Scenes as the paper has them: x = {(p_i, q_i, s_i, c_i)}, absolute, without a hierarchy.

| channels | name | unit |
|---|---|---|
| 0, 1, 2 | centre, ENU | standardised |
| 3 to 6 | quaternion wxyz | - |
| 7, 8, 9 | full extents | standardised |
| 10 to 79 | category, one-hot | - |

Source: the paper's section "Initial Layout and Hierarchy Embedding", x_t.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
import torch
from jaxtyping import Bool, Float, Int

from aeroscene.learning.tokens.batch import TokenBatch, scaled_wish
from aeroscene.learning.tokens.geometry import Geometry
from aeroscene.learning.tokens.kinds import DOMAINS, OPENINGS, Vocabulary, count_kinds
from aeroscene.learning.tokens.skeleton import Skeleton, Wish, token_order
from aeroscene.learning.tokens.symmetry import draw_symmetry
from aeroscene.scene import Scene
from aeroscene.scene.box import rotation_matrix
from aeroscene.scene.catalogue import CATALOGUE, COARSE_COUNT

POSITION, ROTATION, SCALE = slice(0, 3), slice(3, 7), slice(7, 10)
N_GEOMETRY = 10
N_FLAT_CHANNELS = N_GEOMETRY + len(CATALOGUE)
_LEAST_SIZE_M = 0.02
"""A sampled extent may come out negative; the paper says nothing of it."""


@dataclass(frozen=True)
class FlatStatistics:
    """What standardises centres and extents: one mean and spread an axis for all objects."""

    mean: Float[np.ndarray, " 10"]
    spread: Float[np.ndarray, " 10"]
    low: Float[np.ndarray, " 80"]
    """Least value of each channel of x_0 in training."""
    high: Float[np.ndarray, " 80"]


@dataclass(frozen=True)
class FlatExample:
    """One scene: coarse objects first, as a list without parents."""

    x0: Float[np.ndarray, "n 80"]
    n_coarse: int
    wish: Wish


def measure_flat(scenes: Sequence[Scene]) -> FlatStatistics:
    """Statistics of a corpus, under the symmetries of the square."""
    rows = np.concatenate([_rows(scene) for scene in scenes])
    mean, spread = rows.mean(axis=0), rows.std(axis=0)
    mean[[0, 1]] = 0.0
    spread[[0, 1]] = np.sqrt((rows[:, :2] ** 2).mean())
    mean[ROTATION], spread[ROTATION] = 0.0, 1.0
    low, high = np.zeros(N_FLAT_CHANNELS), np.ones(N_FLAT_CHANNELS)
    x0 = (rows - mean) / spread
    low[:N_GEOMETRY], high[:N_GEOMETRY] = x0.min(axis=0), x0.max(axis=0)
    high[:2] = np.abs(x0[:, :2]).max()
    low[:2] = -high[:2]
    low[ROTATION], high[ROTATION] = -1.0, 1.0
    return FlatStatistics(mean, spread, low, high)


def _rows(scene: Scene) -> Float[np.ndarray, "n 10"]:
    return np.array([(*o.bbox.p, *o.bbox.q, *o.bbox.s) for o in token_order(scene)])


def encode_flat(scene: Scene, wish: Wish, *, statistics: FlatStatistics) -> FlatExample:
    """One scene as the paper's x_0, as it would come of a wish."""
    order = token_order(scene)
    x0 = np.zeros((len(order), N_FLAT_CHANNELS))
    x0[:, :N_GEOMETRY] = (_rows(scene) - statistics.mean) / statistics.spread
    categories = [obj.category_id for obj in order]
    x0[np.arange(len(order)), N_GEOMETRY - 1 + np.array(categories)] = 1.0
    return FlatExample(x0, sum(obj.is_coarse for obj in order), wish)


def random_flat_symmetry(example: FlatExample, rng: np.random.Generator) -> FlatExample:
    """The scene turned by quarter turns at random, indoors mirrored too."""
    turns, is_mirrored = draw_symmetry(example.wish.domain, rng)
    x0 = example.x0.copy()
    for _ in range(turns):
        x0[:, 0], x0[:, 1] = -x0[:, 1].copy(), x0[:, 0].copy()
        w, x, y, z = (x0[:, i].copy() for i in range(3, 7))
        half = np.sqrt(0.5)
        x0[:, ROTATION] = half * np.column_stack([w - z, x - y, y + x, z + w])
    if is_mirrored:
        x0[:, [1, 4, 6]] *= -1
    x0[:, ROTATION] *= np.where(x0[:, 3:4] < 0, -1.0, 1.0)
    return FlatExample(x0, example.n_coarse, example.wish)


@dataclass(frozen=True)
class FlatTrainingSet:
    """Scenes as the paper has them, as batches for training."""

    vocabulary: Vocabulary
    statistics: FlatStatistics
    examples: tuple[FlatExample, ...]

    @property
    def known(self) -> FlatStatistics:
        """What a checkpoint keeps of the scenes, beside their kinds."""
        return self.statistics

    @property
    def kinds_json(self) -> str:
        """The kinds of objects as text."""
        return self.vocabulary.to_json()

    @cached_property
    def digest(self) -> str:
        """Sixteen hexadecimal digits that differ between corpora."""
        digest = hashlib.sha256(self.kinds_json.encode())
        for example in self.examples:
            digest.update(np.round(example.x0, 4).astype("<f4").tobytes())
        return digest.hexdigest()[:16]

    @property
    def encoder(self) -> Callable[[Scene, Wish], FlatExample]:
        """From other scenes to examples like these, without these."""
        return partial(encode_flat, statistics=self.statistics)

    def with_examples(self, examples: Sequence[FlatExample]) -> FlatTrainingSet:
        """Other scenes, standardised as these are."""
        return replace(self, examples=tuple(examples))

    def sample_batch(self, size: int, rng: np.random.Generator) -> TokenBatch:
        """Scenes drawn with replacement, each turned at random, indoors mirrored too."""
        picked = rng.integers(len(self.examples), size=size)
        return flat_batch([random_flat_symmetry(self.examples[i], rng) for i in picked])

    def in_order(self, start: int, size: int) -> TokenBatch:
        """Scenes as they are, for measuring."""
        return flat_batch(self.examples[start : start + size])


def flat_training_set(scenes: Sequence[Scene]) -> FlatTrainingSet:
    """The scenes of a corpus and their statistics."""
    statistics = measure_flat(scenes)
    examples = tuple(encode_flat(scene, Wish.of(scene), statistics=statistics) for scene in scenes)
    return FlatTrainingSet(count_kinds(scenes), statistics, examples)


def flat_batch(examples: Sequence[FlatExample]) -> TokenBatch:
    """Batch for training; the kind of a token is the number of its category."""
    wishes = [example.wish for example in examples]
    counts = [(e.n_coarse, len(e.x0) - e.n_coarse) for e in examples]
    batch = empty_flat_batch(wishes, counts)
    assert batch.x0 is not None
    for row, example in enumerate(examples):
        slots = _slots(*counts[row], batch.n_coarse_slots)
        batch.x0[row, slots] = torch.from_numpy(example.x0.astype(np.float32))
        category = 1 + example.x0[:, N_GEOMETRY:].argmax(axis=1)
        batch.kind[row, slots] = torch.from_numpy(category)
    return batch


def empty_flat_batch(wishes: Sequence[Wish], counts: Sequence[tuple[int, int]]) -> TokenBatch:
    """Batch for sampling: only how many objects there are is known, coarse and fine."""
    n_coarse = max(coarse for coarse, _ in counts)
    shape = (len(wishes), n_coarse + max(fine for _, fine in counts))
    mask = torch.zeros(shape, dtype=torch.bool)
    ordinal = torch.zeros(shape, dtype=torch.int64)
    for row, (coarse, fine) in enumerate(counts):
        slots = _slots(coarse, fine, n_coarse)
        mask[row, slots] = True
        ordinal[row, slots] = torch.arange(len(slots))
    zeros = torch.zeros(shape, dtype=torch.int64)
    channels = (*shape, N_FLAT_CHANNELS)
    return TokenBatch(
        kind=zeros.clone(),
        parent=zeros,
        depth=zeros,
        ordinal=ordinal,
        twin=zeros,
        mask=mask,
        domain=torch.tensor([DOMAINS.index(wish.domain) for wish in wishes]),
        wish=torch.from_numpy(np.array([scaled_wish(w) for w in wishes], dtype=np.float32)),
        n_coarse_slots=n_coarse,
        x0=torch.zeros(channels),
        weight=mask[..., None].expand(channels).float(),
    )


def _slots(n_coarse: int, n_fine: int, n_coarse_slots: int) -> Int[np.ndarray, " n"]:
    return np.concatenate([np.arange(n_coarse), n_coarse_slots + np.arange(n_fine)])


def read_flat(
    x0: Float[np.ndarray, "n 80"],
    wish: Wish,
    statistics: FlatStatistics,
    vocabulary: Vocabulary,
    rng: np.random.Generator,
) -> tuple[Skeleton, Geometry]:
    """What a sampled layout says, as a skeleton and its geometry.

    The quaternion is normalised as in the paper's section "Inference Algorithm"; only its yaw is
    kept, since the corpus is upright and a tilt is noise. A fine object belongs to the coarse one
    whose centre is nearest, as in the paper's coarse-to-fine guidance. The kind within a category
    is drawn as often as the corpus has it.
    """
    geometry = x0[:, :N_GEOMETRY] * statistics.spread + statistics.mean
    likely = np.where(_has_kind(vocabulary), x0[:, N_GEOMETRY:], -np.inf)
    category = 1 + likely.argmax(axis=1)
    order = np.argsort(category > COARSE_COUNT, kind="stable")
    geometry, category = geometry[order], category[order]
    n_coarse = int((category <= COARSE_COUNT).sum())
    center = geometry[:, POSITION]
    parent = np.zeros(len(order), dtype=np.int64)
    if n_coarse:
        away = np.linalg.norm(center[n_coarse:, None] - center[None, :n_coarse], axis=-1)
        parent[n_coarse:] = 1 + away.argmin(axis=1)
    kinds = [_draw_kind(int(number), vocabulary, rng) for number in category]
    skeleton = Skeleton(
        wish.domain,
        np.array([DOMAINS.index(wish.domain), *kinds]),
        np.array([0, *parent]),
        1 + n_coarse,
    )
    rotation = rotation_matrix(geometry[:, ROTATION])
    size = np.maximum(geometry[:, SCALE], _LEAST_SIZE_M)
    half_m = np.abs(center[:, :2]).max(axis=0, initial=1.0)
    return skeleton, Geometry(
        np.vstack([[0.0, 0.0, 0.0], center]),
        np.concatenate([[0.0], np.arctan2(rotation[:, 1, 0], rotation[:, 0, 0])]),
        np.vstack([[*(2 * half_m), 1.0], size]),
        np.full((len(skeleton), len(OPENINGS)), np.nan),
    )


def _kinds_of(category: int, vocabulary: Vocabulary) -> list[int]:
    """Kinds without openings, since a flat layout has no channels for them."""
    return [
        number
        for number in np.flatnonzero(vocabulary.category_id == category).tolist()
        if not vocabulary.kinds[number].openings
    ]


def _has_kind(vocabulary: Vocabulary) -> Bool[np.ndarray, " categories"]:
    return np.array([bool(_kinds_of(number, vocabulary)) for number in CATALOGUE])


def _draw_kind(category: int, vocabulary: Vocabulary, rng: np.random.Generator) -> int:
    kinds = _kinds_of(category, vocabulary)
    counts = [sum(look.count for look in vocabulary.looks[number]) for number in kinds]
    return kinds[rng.choice(len(kinds), p=np.array(counts) / sum(counts))]
