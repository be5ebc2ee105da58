"""The script that tries hostile files: what it sees of one that is refused."""

import pytest
from fuzzing.files import all_cases
from fuzzing.files.judging import judge


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
