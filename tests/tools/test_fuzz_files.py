"""The script that tries hostile files: what it sees of one that is refused."""

import pytest
from fuzzing.files import cases_of
from fuzzing.files.judging import judge


@pytest.mark.parametrize(
    ("kind", "name", "most_mb"),
    [
        ("scene", "100,000-objects-packed", 300),
        ("scene", "many-boxes-of-shelves", 300),
        ("layout", "lines-of-values", 300),
        ("settings", "section-control", 150),
        ("checkpoint", "weights-changed", 200),
        ("checkpoint", "network-of-150-GB", 200),
        ("campaign", "table-60-GB-of-text", 300),
        ("recording", "control-pictures", 300),
    ],
)
def test_the_script_sees_status_memory_and_lines(tmp_path, kind, name, most_mb):
    case = next(each for each in cases_of(kind) if each.name == name)
    folder = tmp_path / "000-case"
    folder.mkdir()
    outcome = judge(case.kind, case.name, case.write(folder), folder)
    assert outcome.status == 2
    assert outcome.faults == ()
    assert 20 < outcome.peak_mb < most_mb
    assert ": error: " in outcome.said
