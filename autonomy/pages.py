"""Large arrays of zeros of which only the pages that are touched take memory.

NumPy asks Linux for pages of 2 MiB, and a search that touches a byte in each of them takes all of
the memory.
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
    """Zeros of a shape, in small pages if they are many."""
    n_bytes = math.prod(shape) * np.dtype(dtype).itemsize
    if n_bytes < _LARGE_BYTES:
        return np.zeros(shape, dtype=dtype)
    memory = mmap.mmap(-1, n_bytes, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS)
    with contextlib.suppress(AttributeError, OSError):  # Linux alone has large pages to refuse
        memory.madvise(mmap.MADV_NOHUGEPAGE)
    return np.frombuffer(memory, dtype=dtype).reshape(shape)


def copy_touched(array: np.ndarray) -> np.ndarray:
    """Copy of an array (n, m, ...) that takes no more memory for zeros than the array does."""
    if array.nbytes < _LARGE_BYTES:
        return array.copy()
    copy = untouched_zeros(array.shape, array.dtype)
    for index, part in enumerate(array):
        used = np.flatnonzero(part.reshape(len(part), -1).any(axis=1))
        if len(used):
            copy[index, used[0] : used[-1] + 1] = part[used[0] : used[-1] + 1]
    return copy
