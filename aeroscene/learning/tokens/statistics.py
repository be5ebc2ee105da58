"""Scales of the channels: mean and spread by kind, under the symmetries of the square."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Bool, Float, Int

from aeroscene.learning.tokens.channels import HEADING, HEIGHT, MIRRORED, N_CHANNELS, PLACE, SIZE
from aeroscene.learning.tokens.codec import DEFAULT_CODEC, CodecCfg
from aeroscene.learning.tokens.kinds import DOMAINS, Vocabulary
from aeroscene.learning.tokens.skeleton import Skeleton

_LEAST_SPREAD = 0.02
"""Standard deviations below this are no scale; below a tenth of it a channel is constant."""
_SPREAD_LIMIT = 5.0
"""Values are cut at this many standard deviations."""


@dataclass(frozen=True)
class Statistics:
    """Standardisation of channels, by kind."""

    mean: Float[np.ndarray, "kinds channels"]
    spread: Float[np.ndarray, "kinds channels"]
    low: Float[np.ndarray, "kinds channels"]
    """Least value in training, standardised."""
    high: Float[np.ndarray, "kinds channels"]
    is_free: Bool[np.ndarray, "kinds channels"]
    """Which channels vary; the others are their means."""
    is_relative: Bool[np.ndarray, "kinds 3"]
    """Which extents are taken relative to the parent's."""
    codec: CodecCfg = field(default_factory=CodecCfg)
    """Codec of the channels."""


def standardise(
    skeleton: Skeleton,
    channels: Float[np.ndarray, "n channels"],
    relative_size: Float[np.ndarray, "n 3"],
    statistics: Statistics,
) -> Float[np.ndarray, "n channels"]:
    """Channels with mean 0 and spread 1 by kind, 0 where they do not vary."""
    kind = skeleton.kind_id
    channels = channels.copy()
    is_relative = statistics.is_relative[kind]
    log_size = np.where(is_relative, relative_size, channels[:, SIZE])
    channels[:, SIZE] = statistics.codec.extents(log_size)
    scaled = (channels - statistics.mean[kind]) / statistics.spread[kind]
    scaled = np.where(statistics.is_free[kind], scaled, 0.0)
    return scaled.clip(-_SPREAD_LIMIT, _SPREAD_LIMIT)


def measure(
    vocabulary: Vocabulary,
    skeletons: Sequence[Skeleton],
    raw: Sequence[tuple[np.ndarray, np.ndarray]],
    codec: CodecCfg = DEFAULT_CODEC,
) -> Statistics:
    """Statistics of a corpus; `raw` is what `channels_of` gives for each scene with this codec."""
    kind = np.concatenate([skeleton.kind_id for skeleton in skeletons])
    is_root = np.concatenate([skeleton.parent == 0 for skeleton in skeletons])
    channels = np.concatenate([pair[0] for pair in raw])
    relative = np.concatenate([pair[1] for pair in raw])
    n = vocabulary.n_kinds
    is_relative = np.zeros((n, 3), dtype=bool)
    for k in range(n):
        rows = kind == k
        if rows.any() and not vocabulary.kinds[k].is_site:
            is_relative[k] = relative[rows].std(axis=0) < channels[rows][:, SIZE].std(axis=0)
            # The height of a site follows from what stands on it.
            is_relative[k, 2] &= not is_root[rows].any()
    channels[:, SIZE] = codec.extents(np.where(is_relative[kind], relative, channels[:, SIZE]))
    roots = np.unique(kind[is_root])
    # Kinds whose places feel a quarter turn of the scene.
    turned = np.unique(kind) if codec.frame == "scene" else roots
    mean, spread = np.zeros((2, n, N_CHANNELS))
    low, high = np.zeros((2, n, N_CHANNELS))
    for k in range(n):
        rows = channels[kind == k]
        if len(rows):
            has_root = bool(is_root[kind == k].any())
            is_site = vocabulary.kinds[k].is_site
            mean[k], spread[k] = _moments(rows, has_root=has_root, is_site=is_site)
            if k in turned and not has_root:
                mean[k, PLACE] = 0.0
                spread[k, PLACE] = np.sqrt(np.mean(rows[:, PLACE] ** 2))
            scaled = np.nan_to_num((rows - mean[k]) / np.maximum(spread[k], _LEAST_SPREAD))
            low[k], high[k] = scaled.min(axis=0), scaled.max(axis=0)
    is_free = spread > _LEAST_SPREAD / 10
    is_free[:, HEIGHT] &= np.array([[kind.attachment == "free"] for kind in vocabulary.kinds])
    low, high = _symmetric(low, high, roots, turned)
    if codec.yaw == "angle":
        is_free[len(DOMAINS) :, HEADING.start] = False
        low[roots, HEADING.stop - 1], high[roots, HEADING.stop - 1] = -2.0, 2.0
    return Statistics(
        mean,
        np.maximum(spread, _LEAST_SPREAD),
        low.clip(-_SPREAD_LIMIT, 0),
        high.clip(0, _SPREAD_LIMIT),
        is_free,
        is_relative,
        codec,
    )


def _moments(
    rows: Float[np.ndarray, "k channels"], *, has_root: bool, is_site: bool
) -> tuple[np.ndarray, np.ndarray]:
    """Mean and spread under the symmetries of the square: mirrored always, turned on the site."""
    is_there = ~np.isnan(rows).all(axis=0)
    mean, spread = np.zeros((2, rows.shape[1]))
    mean[is_there] = np.nanmean(rows[:, is_there], axis=0)
    symmetric = list(MIRRORED) + ([0, 1, 3, 4] if has_root else [])
    mean[symmetric] = 0.0
    spread[is_there] = np.sqrt(np.nanmean((rows[:, is_there] - mean[is_there]) ** 2, axis=0))
    if has_root:
        spread[PLACE] = np.sqrt(np.mean(spread[PLACE] ** 2))
    # Headings keep their unit circle; a constant one is the mean.
    if has_root or spread[HEADING].max() > _LEAST_SPREAD:
        mean[HEADING], spread[HEADING] = 0.0, 1.0
    if is_site:
        mean[5:7] = mean[5:7].mean()
        spread[5:7] = np.sqrt(np.mean((rows[:, 5:7] - mean[5:7]) ** 2))
        spread[[0, 1, 2, 7]] = 0.0
        # A mirror turns what is turned at all the other way.
        if np.abs(rows[:, HEADING] - (1.0, 0.0)).max() < _LEAST_SPREAD:
            mean[HEADING], spread[HEADING] = (1.0, 0.0), 0.0
    return mean, spread


def _symmetric(
    low: np.ndarray, high: np.ndarray, roots: Int[np.ndarray, " k"], turned: Int[np.ndarray, " j"]
) -> tuple[np.ndarray, np.ndarray]:
    """Bounds that hold for mirrored and turned scenes too: roots turn, and places of `turned`."""
    widest = np.maximum(-low, high)
    for kinds, first, second in ((turned, 0, 1), (roots, 3, 4)):
        most = widest[kinds][:, [first, second]].max(axis=1)
        widest[kinds, first] = widest[kinds, second] = most
    low, high = low.copy(), high.copy()
    for channel in {*MIRRORED, 0, 3}:
        low[:, channel], high[:, channel] = -widest[:, channel], widest[:, channel]
    sites = slice(0, len(DOMAINS))
    low[sites, 5:7] = low[sites, 5:7].min(axis=1, keepdims=True)
    high[sites, 5:7] = high[sites, 5:7].max(axis=1, keepdims=True)
    return low, high
