"""`aeroscene doctor`: a report of what this machine can do."""

from __future__ import annotations

from dataclasses import dataclass

from rich.table import Table

from scenarios.cli.command_line import EXIT_DONE, EXIT_NEGATIVE, print_json
from scenarios.cli.progress import share_bar
from scenarios.cli.terminal import styled, terminal
from scenarios.doctor.diagnosis import Diagnosis, diagnose

# Only a "problem" keeps the machine from flying; a "note" says that something works in part.
_STYLES = {"ok": "green", "note": "yellow", "problem": "bold red"}


@dataclass(frozen=True, kw_only=True)
class DoctorCfg:
    """Report what this machine can do, by doing it: libraries, ports, a take-off, a camera image.

    Exit status 0 if it can fly, 1 if something essential is missing.
    """

    json: bool = False
    """Print one JSON object: can_fly, and checks with name, status, value and remedy."""


def run(cfg: DoctorCfg) -> int:
    """Run all checks and print the results; return 0 if the machine can fly, else 1."""
    with share_bar() as on_progress:
        diagnosis = diagnose(on_progress)
    if cfg.json:
        print_json(diagnosis.to_json())
    else:
        _print_table(diagnosis)
    return EXIT_DONE if diagnosis.can_fly else EXIT_NEGATIVE


def _print_table(diagnosis: Diagnosis) -> None:
    table = Table("check", "", "finding", "what to do")
    for check in diagnosis.checks:
        status = styled((check.status, _STYLES[check.status]))
        table.add_row(check.name, status, check.value, check.remedy)
    console = terminal()
    console.print(table)
    console.print(
        "This machine can fly." if diagnosis.can_fly else "This machine cannot fly yet: see above."
    )
