import pytest
from hypothesis import given
from hypothesis import strategies as st

from aeroscene.files.names import MOST_CHARACTERS, file_name


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("aeroscene-0042", "aeroscene-0042"),
        ("../../x", "x"),
        ("/etc/passwd", "etc-passwd"),
        ("procthor/../../x y\n", "procthor-..-..-x-y"),
        ("--help", "help"),
        (".bashrc", "bashrc"),
        ("\x1b]0;owned\x07", "0-owned"),
        ("/", "scene"),
        ("..", "scene"),
        ("", "scene"),
        ("楼", "scene"),
    ],
)
def test_a_name_from_a_file_stays_in_its_folder(name, expected):
    assert file_name(name) == expected


@given(st.text())
def test_every_name_is_one_short_visible_file_name(name):
    found = file_name(name)
    assert found
    assert len(found) <= MOST_CHARACTERS
    assert found.isascii()
    assert "/" not in found
    assert found[0] not in ".-"
    assert file_name(found) == found


def test_long_names_that_differ_at_their_end_stay_apart():
    first, second = file_name("a" * 300 + "b"), file_name("a" * 300 + "c")
    assert first != second
    assert len(first) == len(second) == MOST_CHARACTERS
