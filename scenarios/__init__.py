"""Missions, our pilot, runs and their verdicts, recordings, campaigns, the command line.

The names in `__all__` are public, and docs/python.md shows how to use them. They are imported on
first use, because each of them loads a large part of the stack.
"""

from typing import TYPE_CHECKING

from aeroscene.lazy import public_names

# Type checkers read the imports; at run time each name is imported when it is first used.
if TYPE_CHECKING:
    from scenarios.environments import (
        AutopilotCfg,
        EnvironmentCfg,
        ObservationCfg,
        RandomisationCfg,
        make,
        make_vec,
    )
    from scenarios.mission.mission import Mission, plan_mission
    from scenarios.mission.surroundings import MissionError
    from scenarios.pilot import Pilot, PilotCfg
    from scenarios.policies.saving import describe_policy, save_policy
    from scenarios.recording import Recorder, RecordingError, RunInfo
    from scenarios.recording.summary import RecordingSummary, summarise
    from scenarios.run.cfg import SitlCfg
    from scenarios.run.companion import Aboard, Companion
    from scenarios.run.input_errors import INPUT_ERRORS
    from scenarios.run.sitl import Sitl
    from scenarios.trials.result import TrialResult
    from scenarios.trials.verdict import Verdict
else:
    __getattr__, __dir__ = public_names(__name__, __file__)

__all__ = [
    "INPUT_ERRORS",
    "Aboard",
    "AutopilotCfg",
    "Companion",
    "EnvironmentCfg",
    "Mission",
    "MissionError",
    "ObservationCfg",
    "Pilot",
    "PilotCfg",
    "RandomisationCfg",
    "Recorder",
    "RecordingError",
    "RecordingSummary",
    "RunInfo",
    "Sitl",
    "SitlCfg",
    "TrialResult",
    "Verdict",
    "describe_policy",
    "make",
    "make_vec",
    "plan_mission",
    "save_policy",
    "summarise",
]
