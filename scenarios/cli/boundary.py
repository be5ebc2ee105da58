"""Errors of files and of the machine, turned into the one line with which a command ends.

Readers of files check every field themselves and name the one that is wrong. Some faults no reader
foresees, such as a full disk in the middle of an export. A traceback helps a user little there, so
the outermost call of each command passes the exception through `one_line`. Exceptions that may be a
fault of AeroScene's own code keep their traceback.
"""

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
# No space on the device, a quota that is used up, a file larger than the file system allows.
_FULL = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG}


def one_line(error: Exception) -> str | None:
    """Return the line to print for an error that a user can mend.

    Readers of files report which field is wrong. This function covers what none of them foresees: a
    full disk in the middle of an export, a document that is nested without end, a world that MuJoCo
    refuses. With `AEROSCENE_TRACEBACK=1` in the environment it returns None for every error.

    Args:
        error: Exception that a command let through.

    Returns:
        A line that names the fault and what would be valid, or None if the error may be a fault of
        our own code, which needs its traceback.
    """
    if os.environ.get("AEROSCENE_TRACEBACK") == "1":
        return None
    # By name and through the bases: subclasses such as DatasetError, a SceneError, count too.
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
    """Return the line for an operating system's error: the file, the reason, and a way out.

    Args:
        error: Any OSError; without a file name the line holds the reason alone.
    """
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
    """Return exception classes of MuJoCo and pyarrow, as far as these libraries are loaded.

    A library that is not loaded cannot have raised, and importing it here would only cost time.
    """
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
