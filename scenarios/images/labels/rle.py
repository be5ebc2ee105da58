"""Masks as COCO's run lengths, all instances of an image in one pass.

COCO counts runs of pixels column by column, zeros first, and packs the counts into letters: a
count is written as its difference from the one before the last, five bits a letter, the lowest
first. pycocotools does this for one mask at a time; an image with 60 instances takes it 60 passes.

Source: `rleToString` in the COCO API, `common/maskApi.c`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from jaxtyping import Bool, Int

_LETTERS = 7
"""Most letters of a count: 35 bits."""
_FIRST_LETTER = 48


def encode_labels(labels: Int[np.ndarray, "h w"]) -> Mapping[int, dict[str, Any]]:
    """Return the mask of each label in an image, in COCO's compressed form.

    Args:
        labels: Label of each pixel.
    """
    flat = labels.T.ravel()
    first = np.flatnonzero(np.append(True, flat[1:] != flat[:-1]))
    end = np.append(first[1:], len(flat))
    value = flat[first]
    order = np.argsort(value, kind="stable")
    bounds = np.flatnonzero(np.append(True, np.diff(value[order]) != 0))
    size = list(labels.shape)
    masks: dict[int, dict[str, Any]] = {}
    for runs in np.split(order, bounds[1:]):
        # The mask changes where a run of the label begins and where it ends.
        changes = np.column_stack([first[runs], end[runs]]).ravel()
        if changes[-1] < len(flat):
            changes = np.append(changes, len(flat))
        counts = np.diff(changes, prepend=0)
        masks[int(value[runs[0]])] = {"size": size, "counts": _packed(counts)}
    return masks


def encode_mask(mask: Bool[np.ndarray, "h w"]) -> dict[str, Any]:
    """Return a mask with at least one pixel in COCO's compressed form."""
    return encode_labels(mask.astype(np.uint8))[1]


def decode_mask(rle: Mapping[str, Any]) -> Bool[np.ndarray, "h w"]:
    """Return the mask of COCO's compressed form."""
    height, width = rle["size"]
    counts: list[int] = []
    value = shift = 0
    for letter in rle["counts"].encode():
        bits = letter - _FIRST_LETTER
        value |= (bits & 31) << shift
        shift += 5
        if bits & 32:
            continue
        if bits & 16:
            value -= 1 << shift
        counts.append(value + (counts[-2] if len(counts) > 2 else 0))
        value = shift = 0
    is_one = np.arange(len(counts)) % 2 == 1
    return np.repeat(is_one, counts).reshape(width, height).T


def _packed(counts: np.ndarray) -> str:
    left = counts.astype(np.int64)
    left[3:] -= counts[1:-2]
    letters = np.zeros((len(left), _LETTERS), np.uint8)
    is_used = np.zeros(letters.shape, bool)
    is_open = np.ones(len(left), bool)
    for k in range(_LETTERS):
        bits = left & 31
        left >>= 5
        # The highest bit of the last letter is the sign.
        is_more = np.where(bits & 16, left != -1, left != 0)
        letters[:, k] = bits + 32 * is_more + _FIRST_LETTER
        is_used[:, k] = is_open
        is_open &= is_more
    return letters[is_used].tobytes().decode("ascii")
