"""Settings shared by all tests."""

import gc
import os
from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from hypothesis import settings

from tests.cpu_limit import pytest_timeout_set_timer

__all__ = ["pytest_timeout_set_timer"]  # pytest finds the hook here

# Threads of PyTorch and BLAS spin while they wait for each other: a training of a moment took six
# times its CPU time, and more beside another load. Programs that tests start inherit this.
for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ.setdefault(threads, "1")

# The first call of a kernel compiles it: time means nothing here. Draws are fixed, so that a change
# is judged by its effect and not by luck; HYPOTHESIS_PROFILE=thorough searches.
settings.register_profile("fixed", deadline=None, max_examples=25, derandomize=True)
settings.register_profile("thorough", deadline=None, max_examples=300)
profile = os.environ.get("HYPOTHESIS_PROFILE", "fixed")
settings.load_profile(profile)
if profile == "thorough":
    # The limit in pyproject.toml is for the fixed draws.
    os.environ.setdefault("PYTEST_TIMEOUT", "900")


def pytest_collection_finish() -> None:
    """Take what was imported for lasting, else the collector looks through all of it in tests."""
    gc.freeze()


@contextmanager
def single_thread() -> Iterator[None]:
    """One thread for torch: two runs of a network on several do not agree to the last bit."""
    import torch

    before = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(before)


@pytest.fixture
def one_torch_thread() -> Iterator[None]:
    """A test that runs torch on one thread."""
    with single_thread():
        yield
