"""Diagnosis of this machine from all checks.

A check may fail in ways that nobody foresaw, for example by a library that crashes on import. Such
an exception becomes a result of its own, so that one fault does not hide the others.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass
from typing import Any

from scenarios.doctor import flight, machine, network
from scenarios.doctor.check import REINSTALL, Check

GROUPS: Mapping[str, Callable[[], Iterable[Check]]] = {
    "machine": machine.check_machine,
    "libraries": machine.check_libraries,
    "storage": machine.check_storage,
    "ports": network.check_ports,
    "viewer": network.check_viewer,
    "kernels": flight.check_kernels,
    "flight": flight.check_flight,
    "learning": machine.check_learning,
}


@dataclass(frozen=True, kw_only=True, slots=True)
class Diagnosis:
    """Results of all checks, and whether the machine can fly."""

    can_fly: bool
    """True if no check found a problem; notes do not count."""
    checks: tuple[Check, ...]

    def to_json(self) -> dict[str, Any]:
        """Return the diagnosis as plain data."""
        return asdict(self)


def diagnose(
    on_progress: Callable[[str, float], None],
    groups: Mapping[str, Callable[[], Iterable[Check]]] = GROUPS,
) -> Diagnosis:
    """Run all checks. One that raises counts as a problem, and the others still run.

    Args:
        on_progress: Called before each group of checks with its title and the share done.
        groups: Groups of checks by title.
    """
    checks: list[Check] = []
    for i, (title, group) in enumerate(groups.items()):
        on_progress(title, i / len(groups))
        try:
            for check in group():
                checks.append(check)  # noqa: PERF402 - what came before a failure counts
        except Exception as error:  # noqa: BLE001 - whatever breaks is the finding
            value = f"{type(error).__name__}: {' '.join(str(error).split())}"
            checks.append(Check(name=title, status="problem", value=value, remedy=REINSTALL))
    on_progress("done", 1.0)
    return Diagnosis(
        can_fly=all(check.status != "problem" for check in checks), checks=tuple(checks)
    )
