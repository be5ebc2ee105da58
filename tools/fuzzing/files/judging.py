"""Judgement of a command that met a hostile file: status, lines, time, memory, and leftovers."""

from __future__ import annotations

import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

from aeroscene.files.visible import is_visible

# Every honest file of ours needs less.
MOST_MB = 300.0
MOST_CPU_S = 10.0
_PATIENCE_S = 120.0  # a command that hangs is ended, and counts as slow
_STATUSES = (0, 1, 2)
# Started by a process that has imported little: see `_run`.
_STARTER = """import os, pathlib, subprocess, sys, threading
patience_s, folder, *words = sys.argv[1:]
out, err = (open(pathlib.Path(folder) / name, "wb") for name in ("stdout", "stderr"))
program = [sys.executable, "-m", "aeroscene", *words]
process = subprocess.Popen(program, stdin=subprocess.DEVNULL, stdout=out, stderr=err)
timer = threading.Timer(float(patience_s), process.kill)
timer.start()
_, raw, usage = os.wait4(process.pid, 0)
timer.cancel()
print(os.waitstatus_to_exitcode(raw), usage.ru_utime + usage.ru_stime, usage.ru_maxrss)
"""
_OWN_CODE = "owned"
"""Part of the name of whatever the code of a folder would leave."""


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """Result of a case: what the command cost, what it said, and which limits it broke."""

    kind: str
    name: str
    status: int
    cpu_s: float
    wall_s: float
    peak_mb: float
    said: str
    """Last line on standard error."""
    faults: tuple[str, ...]

    def line(self) -> str:
        """Row of a table: the outcome in one line."""
        head = f"{self.kind:<11}{self.name:<34}{self.status:>4}{self.cpu_s:>7.1f} s"
        verdict = f"  !! {', '.join(self.faults)}" if self.faults else ""
        return f"{head}{self.peak_mb:>6.0f} MB  {self.said[:110]}{verdict}"


def judge(kind: str, name: str, words: list[str], folder: Path) -> Outcome:
    """Run the command of a case in the folder of its files, and judge its outcome.

    Args:
        kind: Kind of the case.
        name: Name of the case.
        words: Words behind `aeroscene`.
        folder: Folder of the case's files, one of several in a common folder.
    """
    before = set(folder.rglob("*"))
    # A name such as "../../x" would leave its file beside the folder, and so both are looked at.
    around = set(folder.parent.glob("*"))
    began_s = time.monotonic()
    status, cpu_s, peak_mb = _run(words, folder)
    stdout, stderr = ((folder / each).read_text(errors="replace") for each in ("stdout", "stderr"))
    faults = _faults(status, stdout, stderr)
    if any(_OWN_CODE in path.name for path in set(folder.rglob("*")) - before):
        faults.append("ran the code of the folder")
    # Folders of other cases, which run at the same time, begin with three digits.
    others = {path for path in set(folder.parent.glob("*")) - around if not path.name[:3].isdigit()}
    if others:
        faults.append(f"wrote {sorted(path.name for path in others)}")
    if peak_mb > MOST_MB:
        faults.append("memory")
    if cpu_s > MOST_CPU_S:
        faults.append("time")
    return Outcome(
        kind=kind,
        name=name,
        status=status,
        cpu_s=round(cpu_s, 1),
        wall_s=round(time.monotonic() - began_s, 1),
        peak_mb=round(peak_mb),
        said=(stderr.strip().splitlines() or [""])[-1],
        faults=tuple(faults),
    )


def _run(words: list[str], folder: Path) -> tuple[int, float, float]:
    """Exit status, CPU time in s and peak of memory in MB of a command.

    A process inherits the peak of the one that starts it, so a small one starts it.
    """
    found = subprocess.run(  # noqa: S603 - our own program
        [sys.executable, "-c", _STARTER, str(_PATIENCE_S), str(folder), *words],
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        check=True,
        # Python looks for modules in the working folder: a campaign's own `owned.py` could be
        # imported.
        cwd=folder / "c" if (folder / "c").is_dir() else folder,
    )
    status, cpu_s, peak = found.stdout.split()
    # macOS counts bytes, Linux kibibytes.
    bytes_a_unit = 1 if sys.platform == "darwin" else 1024
    return int(status), float(cpu_s), int(peak) * bytes_a_unit / 1e6


def _faults(status: int, stdout: str, stderr: str) -> list[str]:
    faults: list[str] = []
    if status not in _STATUSES:
        faults.append(f"status {status}")
    if "Traceback" in stderr:
        faults.append("traceback")
    # A traceback has been counted already.
    elif status == 2 and len([line for line in stderr.splitlines() if ": error: " in line]) != 1:
        faults.append("not one line")
    if not all(is_visible(line) for line in (stdout + stderr).split("\n")):
        faults.append("control characters")
    return faults
