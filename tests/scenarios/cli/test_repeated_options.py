"""Options named once for each value, which tyro alone would drop but the last."""

import pytest

from scenarios.cli.repeated_options import gathered


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ("42 --speed max", "42 --speed max"),
        ("--out a --out b 42", "42 --out a b"),
        ("--out=a 42 --out=b", "42 --out a b"),
        ("--out a --speed max", "--speed max --out a"),
        ("--format png --format svg", "--format png svg"),
        ("42 --camera a b --json --camera c", "42 --json --camera a b c"),
    ],
)
def test_all_values_are_kept(given, expected):
    assert gathered(given.split()) == expected.split()


def test_an_option_without_a_value_stays_an_error():
    assert gathered(["42", "--out"]) == ["42", "--out", ""]
