"""Settings that all tests share."""

from hypothesis import settings

# The first call of a kernel compiles it: time says nothing here.
settings.register_profile("aeroscene", deadline=None, max_examples=60)
settings.load_profile("aeroscene")
