"""The computer: interpreter, processor, memory, disk, libraries."""

from __future__ import annotations

import importlib
import importlib.metadata
import os
import platform
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path

from scenarios.doctor.check import REINSTALL, Check

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
"""Distributions without which something does not work."""
_LEAST_MEMORY_MB = 1000


def check_machine() -> Iterator[Check]:
    """Interpreter, processor and memory."""
    version = platform.python_version()
    is_supported = sys.version_info[:2] in SUPPORTED_PYTHONS
    yield Check(
        name="python",
        status="ok" if is_supported else "problem",
        value=f"{version} on {platform.platform(terse=True)}",
        remedy="" if is_supported else "install Python 3.11, 3.12 or 3.13",
    )
    yield Check(name="processor", status="ok", value=f"{_processor()}, {_usable_cores()} cores")
    memory_mb = _memory_mb()
    is_enough = memory_mb is None or memory_mb >= _LEAST_MEMORY_MB
    yield Check(
        name="memory",
        status="ok" if is_enough else "note",
        value="unknown" if memory_mb is None else f"{memory_mb / 1000:.1f} GB",
        remedy="" if is_enough else "a flight with cameras takes about 1 GB: close something",
    )


def check_libraries() -> Iterator[Check]:
    """Whether everything is installed, and which version."""
    for name in LIBRARIES:
        try:
            version = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            yield Check(name=name, status="problem", value="missing", remedy=REINSTALL)
        else:
            yield Check(name=name, status="ok", value=version)


def check_learning() -> Iterator[Check]:
    """What torch would compute on; nothing here needs it."""
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
    """Whether the cache can be kept, and how much room recordings have."""
    import platformdirs  # noqa: PLC0415 - with the check

    cache = Path(os.environ.get("AEROSCENE_CACHE_DIR") or platformdirs.user_cache_dir("aeroscene"))
    is_writable = _is_writable(cache)
    size_mb = sum(p.stat().st_size for p in cache.rglob("*") if p.is_file()) / 1e6
    yield Check(
        name="cache",
        status="ok" if is_writable else "note",
        value=f"{cache}, {size_mb:.0f} MB" + ("" if is_writable else ", not writable"),
        remedy="" if is_writable else "make it writable, or set AEROSCENE_CACHE_DIR to a folder",
    )
    free_gb = shutil.disk_usage(Path.cwd()).free / 1e9
    yield Check(name="disk", status="ok", value=f"{free_gb:.0f} GB free for recordings")


def _processor() -> str:
    """What the processor calls itself."""
    information = Path("/proc/cpuinfo")
    if information.exists():
        for line in information.read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def _usable_cores() -> int:
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _memory_mb() -> float | None:
    """Memory that a new program can have; None where the system does not tell."""
    information = Path("/proc/meminfo")
    if information.exists():
        for line in information.read_text().splitlines():
            if line.startswith("MemAvailable"):
                return int(line.split()[1]) * 1.024e-3
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
