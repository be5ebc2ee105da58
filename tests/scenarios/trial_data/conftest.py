"""The flight that `recording` records, read back as data."""

import pytest

from scenarios.trial_data.reading import RecordedTrial, read_trial
from tests.scenarios.recording.conftest import flight, strict

__all__ = ["flight", "strict"]


@pytest.fixture(scope="session")
def trial(flight) -> RecordedTrial:
    return read_trial(flight.path)
