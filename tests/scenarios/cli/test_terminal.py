"""Texts from files, pilots and users reach the terminal as they are, brackets and all."""

import shlex
import subprocess
import sys
from dataclasses import fields
from io import StringIO
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from rich.console import Console
from rich.table import Table

from flightsim.bridges.launch.launch import Launch
from scenarios.cli import doctor, fly, progress, training_bar
from scenarios.cli.compare import _print as print_comparison
from scenarios.cli.dataset.validate import _print as print_validation
from scenarios.cli.layouts import LayoutsCfg
from scenarios.cli.layouts import run as run_layouts
from scenarios.cli.report import print_summary
from scenarios.cli.sitl_words import print_results
from scenarios.cli.terminal import plain_column, shell, styled, terminal
from scenarios.dataset.drop_test import DropReport
from scenarios.dataset.validate import Report
from scenarios.doctor.check import Check
from scenarios.doctor.diagnosis import Diagnosis
from scenarios.run.results import RunResult
from scenarios.trials.result import TrialResult
from scenarios.trials.verdict import Code
from tests.aeroscene.layouts.samples import house, write_lines

HOSTILE = "[/speed] [bold]x[/] [model] :car:"
"""A tag that closes nothing, one that would style, one that would vanish, and a picture's name."""


@pytest.fixture
def shown(capsys):
    """What has been printed, in one line: terminals and tables break lines."""
    return lambda: " ".join(capsys.readouterr().out.split())


def test_text_titles_and_cells_are_printed_as_they_are(shown):
    table = Table("name", HOSTILE, title=HOSTILE)
    table.add_row(HOSTILE, styled((HOSTILE, "bold red")))
    console = terminal(width=200)
    console.print(HOSTILE)
    console.print(styled(HOSTILE, (HOSTILE, "bold")))
    console.print(table)
    assert shown().count(HOSTILE) == 7


def test_a_style_reaches_a_terminal_that_has_colours():
    out = StringIO()
    console = Console(file=out, force_terminal=True, markup=False, color_system="standard")
    console.print(styled("a ", ("b", "bold")))
    assert out.getvalue() == "a \x1b[1mb\x1b[0m\n"


def test_titles_of_progress_bars_are_shown_as_they_are(monkeypatch):
    out = StringIO()
    console = Console(file=out, force_terminal=True, width=160, markup=False, emoji=False)
    for module in (progress, training_bar):
        monkeypatch.setattr(module, "terminal", lambda **_: console)
    with progress.share_bar() as on_progress:
        on_progress(HOSTILE, 0.5)
    with progress.progress_bar(HOSTILE, 2):
        pass
    with training_bar.training_bar() as bar:
        bar.show(HOSTILE, 0.5, {"total": 1.0})
    assert out.getvalue().count(HOSTILE) >= 3
    assert plain_column("{task.description}").markup is False


def test_doctor_names_the_extra_that_is_to_be_installed(shown, monkeypatch):
    monkeypatch.setattr(doctor, "terminal", lambda: terminal(width=200))
    remedy = "pip install 'aeroscene[model]'"
    check = Check(name="learning", status="note", value="no torch", remedy=remedy)
    doctor._print_table(Diagnosis(can_fly=True, checks=(check,)))
    assert remedy in shown()


def test_fly_gives_the_verdict_of_a_pilot_that_raised_with_brackets(shown):
    row: dict[str, Any] = {
        "trial_id": "42/iris/0",
        "success": False,
        "code": "raised",
        "reason": "KeyError: 'config[/speed]'",
        "recording": "my runs/42 [a].rrd",
    }
    fly._print_row(row, is_same=None)
    said = shown()
    assert "42/iris/0 Failed, raised: KeyError: 'config[/speed]'" in said
    assert said.endswith("Replay it with: aeroscene replay 'my runs/42 [a].rrd'")


def test_the_verdict_of_sitl_keeps_its_reason_and_quotes_the_recording(shown):
    values: dict[str, Any] = dict.fromkeys(field.name for field in fields(TrialResult))
    values |= {"success": False, "reason": HOSTILE, "code": next(iter(Code)), "contacts": ()}
    values |= {"sim_seconds": 1.0, "wall_seconds": 1.0, "real_time_factor": 1.0}
    result = _result(values | {"recording": "a b/$(x).rrd"})
    print_results(terminal(width=200), RunResult(first_system=1, vehicles=(result,)))
    said = shown()
    assert HOSTILE in said
    assert said.endswith("Replay it with: aeroscene replay 'a b/$(x).rrd'")


@pytest.mark.parametrize("kind", ["Bed[/b]", "Bed [bold]", "Lamp[model]"])
def test_layouts_shows_kinds_with_brackets(tmp_path, shown, kind):
    record = house()
    record["objects"][1]["category"] = kind
    path = write_lines(tmp_path / "a[b].jsonl", record)
    assert run_layouts(LayoutsCfg(file=path, skip_invalid=True)) in {0, 1}
    said = shown()
    assert "a[b].jsonl" in said
    assert kind in said


def test_tables_of_campaigns_and_datasets_keep_brackets(shown):
    console = terminal(width=200)
    rate = {"trials": 2, "success_rate": 0.5, "interval_95": (0.1, 0.9)}
    groups = {"vehicle": {HOSTILE: rate, "b": rate}}
    print_summary(
        console,
        {**rate, "phases": {}, "groups": groups, "codes": {}, "without_task": 0, "words": None},
    )
    side = {"pilot": HOSTILE, "folder": HOSTILE, "without_pair": 0, **rate}
    found = {"pairs": 1, "a": side, "b": side, "difference": 0.0, "interval_95": (0.0, 0.1)}
    found |= dict.fromkeys(("a_alone", "b_alone", "both", "neither"), 0)
    print_comparison(console, found | {"p_value": 1.0, "figures": (), "differing": ()}, {})
    report = SimpleNamespace(invalid=[HOSTILE], n_scenes=0, findings=(), counts=dict)
    drop = SimpleNamespace(scene_id=HOSTILE, drone_class="small", area_id=1, faults=("x",))
    drops = SimpleNamespace(share=0.5, drops=(drop,), failed=(drop,))
    print_validation(console, _as(Report, report), _as(DropReport, drops))
    assert shown().count(HOSTILE) == 7


def _result(values: dict[str, Any]) -> TrialResult:
    kind: Any = TrialResult
    return kind(**values)


def _as(_kind: type[Any], value: Any) -> Any:
    return value


def test_a_command_to_paste_survives_the_shell():
    words = ("aeroscene", "replay", Path("my runs/it's $(touch x) [1].rrd"))
    assert shlex.split(shell(*words)) == [str(word) for word in words]


def test_the_line_that_starts_a_flight_stack_keeps_the_path_and_quotes_the_rest():
    launch = Launch(arguments=["-i", "a b"], environment={"PATH": "/my temp/x:$PATH", "N": "1"})
    assert launch.line("px4") == "PATH='/my temp/x:'$PATH N=1 px4 -i 'a b'"


def test_the_linter_refuses_other_terminals(tmp_path):
    """Otherwise the next command brings markup back."""
    sample = Path(__file__).parents[3] / "scenarios" / "cli" / "another.py"
    found = subprocess.run(
        [sys.executable, "-m", "ruff", "check", "--select", "TID251", "--stdin-filename", sample]
        + ["-"],
        input="from rich.console import Console\nfrom rich.progress import TextColumn\n",
        capture_output=True,
        text=True,
        check=False,
        cwd=sample.parents[2],
    )
    assert found.stdout.count("TID251") == 2
