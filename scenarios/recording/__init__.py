"""Runs in rerun's format: the recorder, the entities that it writes, and the way back from a file.

Only this package knows rerun, so that another format, or a new version of rerun, changes nothing
else.
"""

from scenarios.recording import rerun_logging  # noqa: F401 - before anything that loads rerun
from scenarios.recording.metadata import RunInfo
from scenarios.recording.output import RecordingError
from scenarios.recording.recorder import Recorder

__all__ = ["Recorder", "RecordingError", "RunInfo"]
