"""Settings that all tests share."""

import os

from hypothesis import settings

# The first call of a kernel compiles it: time says nothing here.
settings.register_profile("aeroscene", deadline=None, max_examples=60)
settings.register_profile("thorough", deadline=None, max_examples=1000)
# What a submission is judged by must not depend on luck.
settings.register_profile("ci", deadline=None, max_examples=60, derandomize=True)
settings.load_profile(
    os.environ.get("HYPOTHESIS_PROFILE", "ci" if os.environ.get("CI") else "aeroscene")
)
