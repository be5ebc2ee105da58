"""All that learns runs on one thread of torch."""

from collections.abc import Iterator

import pytest

from tests.conftest import single_thread


@pytest.fixture(autouse=True, scope="session")
def one_thread() -> Iterator[None]:
    """From the first of these tests to the end, sessions' models included."""
    with single_thread():
        yield
