"""A recorded trial as tables and images."""

from scenarios.trial_data.reading.trial import RecordedTrial, TrialDataError, read_trial

__all__ = ["RecordedTrial", "TrialDataError", "read_trial"]
