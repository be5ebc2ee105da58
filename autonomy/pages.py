"""Large arrays of zeros of which only the pages that are touched take memory.

A map of a large site is mostly untouched. NumPy asks Linux for pages of 2 MiB, and a search that
touches a byte in each of them takes all of the memory. These arrays therefore ask for small pages.
"""

from __future__ import annotations

import contextlib
import math
import mmap
from typing import Any

import numpy as np

_LARGE_BYTES = 128 << 20
"""Size up to which NumPy's own zeros are used, which are a little faster to touch."""


def untouched_zeros(shape: tuple[int, ...], dtype: Any) -> np.ndarray:
    """Return an array of zeros; a large one takes memory only for the small pages that are touched.

    Arrays below `_LARGE_BYTES` are NumPy's own.
    """
    n_bytes = math.prod(shape) * np.dtype(dtype).itemsize
    if n_bytes < _LARGE_BYTES:
        return np.zeros(shape, dtype=dtype)
    memory = mmap.mmap(-1, n_bytes, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS)
    with contextlib.suppress(AttributeError, OSError):  # Linux alone has large pages to refuse
        memory.madvise(mmap.MADV_NOHUGEPAGE)
    return np.frombuffer(memory, dtype=dtype).reshape(shape)


def copy_touched(array: np.ndarray) -> np.ndarray:
    """Copy an array (n, m, ...) so that its zeros take no more memory than in the original.

    Only the span of rows that hold other values is written, for each index of the first axis.
    """
    if array.nbytes < _LARGE_BYTES:
        return array.copy()
    copy = untouched_zeros(array.shape, array.dtype)
    for index, part in enumerate(array):
        used = np.flatnonzero(part.reshape(len(part), -1).any(axis=1))
        if len(used):
            copy[index, used[0] : used[-1] + 1] = part[used[0] : used[-1] + 1]
    return copy
