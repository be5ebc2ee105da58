"""Settings shared by all tests."""

import os

from hypothesis import settings

# The first call of a kernel compiles it: time means nothing here. Draws are fixed, so that a change
# is judged by its effect and not by luck; HYPOTHESIS_PROFILE=thorough searches.
settings.register_profile("fixed", deadline=None, max_examples=60, derandomize=True)
settings.register_profile("thorough", deadline=None, max_examples=1000)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "fixed"))
