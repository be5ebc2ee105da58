"""More of the same, which a change is not held against by default.

Most claims are proved by a few cases; where a test has many that go one and the same way, those
beyond them carry this mark and run with HYPOTHESIS_PROFILE=thorough.
"""

import os

import pytest

IS_THOROUGH = os.environ.get("HYPOTHESIS_PROFILE") == "thorough"
THOROUGH = pytest.mark.skipif(
    not IS_THOROUGH, reason="more of the same: HYPOTHESIS_PROFILE=thorough"
)
