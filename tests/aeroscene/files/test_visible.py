"""Names from files on a terminal: nothing that it would obey, or that hides."""

import pytest

from aeroscene.files.visible import is_visible, visible


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("Scene 42, Bär :car: [bold]", "Scene 42, Bär :car: [bold]"),
        ("\x1b]0;title\x07", "\\x1b]0;title\\x07"),
        ("\x9b31m", "\\x9b31m"),
        ("gpj.\u202escene", "gpj.\\u202escene"),
        ("a\nb", "a\\nb"),
        ("\ud800", "\\ud800"),
    ],
)
def test_a_terminal_gets_escapes_of_what_it_would_obey(text, shown):
    assert visible(text) == shown
    assert is_visible(text) == (text == shown)
    assert is_visible(shown)
