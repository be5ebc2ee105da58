"""Errors of files and of the machine, as the one line in which a command ends because of them."""

from __future__ import annotations

import errno
import os
import sys
import tomllib
from types import ModuleType

import msgspec

INPUT_ERROR_NAMES = frozenset(
    {
        "aeroscene.scene.errors.SceneError",
        "flightsim.environment.effects.EffectError",
        "flightsim.environment.traffic.TrafficError",
        "flightsim.plant.timed_failures.TimedFailureError",
        "flightsim.environment.wind.WindError",
        "flightsim.mavlink.links.link.LinkError",
        "flightsim.cameras.view.CameraError",
        "flightsim.lidars.definition.LidarError",
        "flightsim.looks.weather.words.WeatherError",
        "flightsim.world.starts.WorldError",
        "flightsim.testbench.cfg.TestbenchError",
        "flightsim.vehicles.airframe.AirframeError",
    }
)
"""The classes of `scenarios.INPUT_ERRORS`, by name. Importing them loads the whole simulator, a
second that a refusal should not cost."""
_FULL = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG}


def one_line(error: Exception) -> str | None:
    """What to say of an error that a user can mend; None where the fault may be ours.

    Readers of files say which field is wrong. This is for what none of them has foreseen: a full
    disk in the middle of an export, a document that is nested without end, a world that MuJoCo
    refuses. `AEROSCENE_TRACEBACK=1` shows all of them with their traceback.
    """
    if os.environ.get("AEROSCENE_TRACEBACK") == "1":
        return None
    if any(f"{kind.__module__}.{kind.__name__}" in INPUT_ERROR_NAMES for kind in type(error).mro()):
        return str(error)
    if isinstance(error, OSError):
        return of_file(error)
    if isinstance(error, MemoryError):
        return "there is not enough memory; valid: a smaller scene or file"
    if isinstance(error, RecursionError):
        return "a file is nested too deeply; valid: one that a program of ours has written"
    if isinstance(error, (tomllib.TOMLDecodeError, msgspec.DecodeError)):
        return f"a file is damaged: {error}; valid: one that was written whole"
    if isinstance(error, _library_errors()):
        return f"{error}; valid: a whole file, and a world that can be built"
    return None


def of_file(error: OSError) -> str:
    """Which file cannot be read or written, and why."""
    reason = (error.strerror or str(error) or type(error).__name__).lower()
    if error.errno in _FULL:
        valid = "a disk with room"
    elif error.filename:
        valid = "a path that you may read or write"
    else:
        return reason
    said = f"file {str(error.filename)!r}: {reason}" if error.filename else reason
    return f"{said}; valid: {valid}"


def _library_errors() -> tuple[type[Exception], ...]:
    """Errors of MuJoCo and pyarrow, as far as they are loaded."""
    found = [
        getattr(_loaded(module), name, None)
        for module, name in (
            ("mujoco", "FatalError"),
            ("mujoco", "UnexpectedError"),
            ("pyarrow", "ArrowException"),
        )
    ]
    return tuple(kind for kind in found if kind is not None)


def _loaded(module: str) -> ModuleType | None:
    return sys.modules.get(module)
