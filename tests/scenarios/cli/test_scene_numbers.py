import pytest
from hypothesis import given
from hypothesis import strategies as st

from scenarios.cli.scene_numbers import SceneNumbersError, scene_numbers


@pytest.mark.parametrize(
    ("text", "numbers"),
    [
        ("42", (42,)),
        ("0:3", (0, 1, 2)),
        ("7,2:4,3", (2, 3, 7)),
        ("1015:1018", (1015, 1016, 1017)),
        ("999999", (999_999,)),
    ],
)
def test_ranges_and_single_numbers_join(text, numbers):
    assert scene_numbers(text) == numbers


@pytest.mark.parametrize(
    "text", ["", "3:3", "5:2", "1000000", "0:1000001", "-1", "1:", "1,,2", "١"]
)
def test_what_names_no_scene_is_refused_with_what_would(text):
    with pytest.raises(SceneNumbersError, match="valid: A:B"):
        scene_numbers(text)


@given(st.sets(st.integers(0, 999_999), min_size=1))
def test_numbers_written_one_by_one_come_back_in_order(numbers):
    assert scene_numbers(",".join(map(str, numbers))) == tuple(sorted(numbers))
