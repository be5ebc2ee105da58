"""Settings shared by all tests."""

import os

from hypothesis import settings

# The first call of a kernel compiles it: time means nothing here. Draws are fixed, so that a change
# is judged by its effect and not by luck; HYPOTHESIS_PROFILE=thorough searches.
settings.register_profile("fixed", deadline=None, max_examples=60, derandomize=True)
settings.register_profile("thorough", deadline=None, max_examples=300)
profile = os.environ.get("HYPOTHESIS_PROFILE", "fixed")
settings.load_profile(profile)
if profile == "thorough":
    # The timeout in pyproject.toml is for the fixed draws.
    os.environ.setdefault("PYTEST_TIMEOUT", "900")
