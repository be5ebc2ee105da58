"""Large zeros take no memory until they are touched, and copies take no more than they do."""

import resource
import sys
from pathlib import Path

import numpy as np
import pytest

from autonomy.pages import copy_touched, untouched_zeros

SHAPE = (600, 600, 600)


def _resident_bytes() -> int:
    return int(Path("/proc/self/statm").read_text().split()[1]) * resource.getpagesize()


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
def test_only_what_is_touched_takes_memory():
    before = _resident_bytes()
    zeros = untouched_zeros(SHAPE, np.uint8)
    zeros[::6, ::60, 0] = 1
    copy = copy_touched(zeros)
    assert np.array_equal(copy[::6], zeros[::6])
    # 200 MB each; the copy holds the used span of each row.
    assert _resident_bytes() - before < 60e6


@pytest.mark.parametrize("shape", [(4, 5, 6), SHAPE])
def test_zeros_are_zeros_of_the_shape_and_can_be_written(shape):
    zeros = untouched_zeros(shape, np.uint8)
    assert zeros.shape == shape
    assert zeros.dtype == np.uint8
    assert not zeros[:2].any()
    zeros[1, 2, 3] = 7
    copy = copy_touched(zeros)
    copy[1, 2, 3] = 9
    assert zeros[1, 2, 3] == 7
