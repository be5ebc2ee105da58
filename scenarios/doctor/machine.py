"""Checks of the computer: interpreter, processor, memory, disk and libraries."""

from __future__ import annotations

import importlib
import importlib.metadata
import os
import platform
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path

from aeroscene.files import cache_folder
from aeroscene.processes import default_jobs
from scenarios.doctor.check import REINSTALL, Check, judged

SUPPORTED_PYTHONS = ((3, 11), (3, 12), (3, 13))
LIBRARIES = (
    "mujoco-core",
    "numpy",
    "numba",
    "scipy",
    "casadi",
    "pymavlink",
    "rerun-sdk",
    "opencv-python-headless",
    "embreex",
    "shapely",
    "msgspec",
    "tyro",
)
"""Distributions without which some part does not work."""
_LEAST_MEMORY_MB = 1000


def check_machine() -> Iterator[Check]:
    """Check interpreter, processor and memory."""
    yield judged(
        "python",
        f"{platform.python_version()} on {platform.platform(terse=True)}",
        "install Python 3.11, 3.12 or 3.13",
        is_fine=sys.version_info[:2] in SUPPORTED_PYTHONS,
        fault="problem",
    )
    yield Check(name="processor", status="ok", value=f"{_processor()}, {default_jobs()} cores")
    memory_mb = _memory_mb()
    value = "unknown" if memory_mb is None else f"{memory_mb / 1000:.1f} GB"
    remedy = "a flight with cameras takes about 1 GB: close something"
    is_enough = memory_mb is None or memory_mb >= _LEAST_MEMORY_MB
    yield judged("memory", value, remedy, is_fine=is_enough)


def check_libraries() -> Iterator[Check]:
    """Check that every library is installed, and report its version."""
    # Metadata alone: importing all of them would take seconds.
    for name in LIBRARIES:
        try:
            version = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            yield Check(name=name, status="problem", value="missing", remedy=REINSTALL)
        else:
            yield Check(name=name, status="ok", value=version)


def check_learning() -> Iterator[Check]:
    """Report the device that PyTorch would compute on.

    A machine without PyTorch is fine, because only the scene model needs it.
    """
    try:
        torch = importlib.import_module("torch")
    except ModuleNotFoundError:
        value = "not installed; only the scene model needs it: pip install 'aeroscene[model]'"
        yield Check(name="torch", status="ok", value=value)
        return
    device = "cpu"
    if torch.cuda.is_available():
        device = f"cuda, {torch.cuda.get_device_name()}"
    elif torch.backends.mps.is_available():
        device = "mps"
    yield Check(name="torch", status="ok", value=f"{torch.__version__} on {device}")


def check_storage() -> Iterator[Check]:
    """Check that the cache is writable, and report the room for recordings.

    Without a cache, kernels compile anew in each process, so that is worth a note.
    """
    cache = cache_folder("")
    remedy = "make it writable, or set AEROSCENE_CACHE_DIR to a folder"
    if cache is None:
        is_off = os.environ.get("AEROSCENE_CACHE", "").lower() == "off"
        value = "off, by AEROSCENE_CACHE" if is_off else "none: the user has no home folder"
        yield judged("cache", value, remedy, is_fine=is_off)
    else:
        is_writable = _is_writable(cache)
        value = f"{cache}, {_size_mb(cache):.0f} MB" + ("" if is_writable else ", not writable")
        yield judged("cache", value, remedy, is_fine=is_writable)
    free_gb = shutil.disk_usage(Path.cwd()).free / 1e9
    yield Check(name="disk", status="ok", value=f"{free_gb:.0f} GB free for recordings")


def _size_mb(folder: Path) -> float:
    """Return the size of the files in a folder, 0 if it cannot be read."""
    # The folder may not exist yet, or belong to another user.
    if not os.access(folder, os.R_OK | os.X_OK):
        return 0.0
    return sum(path.stat().st_size for path in folder.rglob("*") if path.is_file()) / 1e6


def _linux_says(file: str, name: str) -> str | None:
    """Return the first value of a name in a file of /proc, None if there is none."""
    information = Path("/proc") / file
    lines = information.read_text().splitlines() if information.exists() else []
    return next((line.partition(":")[2].strip() for line in lines if line.startswith(name)), None)


def _processor() -> str:
    return _linux_says("cpuinfo", "model name") or platform.processor() or platform.machine()


def _memory_mb() -> float | None:
    """Return the memory available to a new program, None if the system does not report it."""
    if (available := _linux_says("meminfo", "MemAvailable")) is not None:
        return int(available.split()[0]) * 1.024e-3  # /proc counts in KiB
    # macOS reports the whole memory only, which at least shows a machine that is too small.
    try:
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") * 1e-6
    except (ValueError, OSError):
        return None


def _is_writable(folder: Path) -> bool:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return False
    return os.access(folder, os.W_OK)
