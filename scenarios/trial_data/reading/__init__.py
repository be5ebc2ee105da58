"""A recorded trial as tables and images."""

from scenarios.trial_data.reading.error import TrialDataError
from scenarios.trial_data.reading.images import decoded
from scenarios.trial_data.reading.trial import RecordedTrial, read_trial

__all__ = ["RecordedTrial", "TrialDataError", "decoded", "read_trial"]
