"""Hostile files of every kind, in the test's own process: one line and status 2, or taken."""

import sys
from pathlib import Path

import pytest
from fuzzing.files import all_cases
from fuzzing.files.judging import judge

from aeroscene.visible import is_visible
from tests.scenarios.in_process import in_process

QUICK_BYTES = 3_000_000
SLOW = frozenset(("checkpoint", "outline", "settings", "dataset"))
"""Kinds whose commands load the scene model or start processes: the script has them."""


def test_every_quick_case_is_refused_in_one_line_or_taken(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(sys, "path", [*sys.path])
    faults: list[str] = []
    n_cases = 0
    for case in all_cases():
        if case.kind in SLOW or sum(map(len, case.files.values())) > QUICK_BYTES:
            continue
        n_cases += 1
        folder = tmp_path / f"{case.kind}-{case.name}"
        folder.mkdir()
        words = case.write(folder)
        monkeypatch.chdir(folder / "c" if (folder / "c").is_dir() else folder)
        before = {path for path in tmp_path.rglob("*") if folder not in path.parents}
        try:
            status, out, err = in_process(capsys, *words)
        except Exception as error:  # noqa: BLE001 - any is the fault that is looked for
            faults.append(f"{folder.name}: {type(error).__name__}: {error}")
            continue
        if status not in {0, 1, 2} or (status == 2 and err.count(": error: ") != 1):
            faults.append(f"{folder.name}: {status}, {err!r}")
        if not all(map(is_visible, (out + err).split("\n"))):
            faults.append(f"{folder.name}: control characters in {out + err!r}")
        if (folder / "owned").exists() or _escaped(tmp_path, folder, before):
            faults.append(f"{folder.name}: wrote outside its folder, or ran its code")
    assert n_cases >= 200
    assert not faults, "\n".join(faults)


def _escaped(tmp_path: Path, folder: Path, before: set[Path]) -> set[Path]:
    return {path for path in tmp_path.rglob("*") if folder not in path.parents} - before


@pytest.mark.parametrize(
    ("name", "most_mb"), [("100,000-objects-packed", 300), ("lines-of-values", 300)]
)
def test_the_script_sees_status_memory_and_lines(tmp_path, name, most_mb):
    case = next(each for each in all_cases() if each.name == name)
    folder = tmp_path / "000-case"
    folder.mkdir()
    outcome = judge(case.kind, case.name, case.write(folder), folder)
    assert outcome.status == 2
    assert outcome.faults == ()
    assert 20 < outcome.peak_mb < most_mb
    assert ": error: " in outcome.said
