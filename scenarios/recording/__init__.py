"""Runs in rerun's format: the recorder, what it writes where, and reading it back.

Only this package and `scenarios.recording.viewer` know rerun.
"""

from scenarios.recording import quiet  # noqa: F401 - before anything that loads rerun
from scenarios.recording.metadata import RunInfo
from scenarios.recording.output import RecordingError
from scenarios.recording.recorder import Recorder

__all__ = ["Recorder", "RecordingError", "RunInfo"]
