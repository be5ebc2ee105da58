"""The script that tries hostile files: what it sees of one that is refused."""

import pytest
from fuzzing.files import cases_of
from fuzzing.files.judging import judge

from tests.thorough import THOROUGH


@pytest.mark.parametrize(
    ("kind", "name", "most_mb"),
    [
        ("scene", "100,000-objects-packed", 300),
        pytest.param("scene", "many-boxes-of-shelves", 300, marks=THOROUGH),
        pytest.param("layout", "lines-of-values", 300, marks=THOROUGH),
        ("settings", "section-control", 150),
        pytest.param("checkpoint", "weights-changed", 200, marks=THOROUGH),
        ("checkpoint", "network-of-150-GB", 200),
        ("campaign", "table-60-GB-of-text", 300),
        pytest.param("recording", "control-pictures", 300, marks=THOROUGH),
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
