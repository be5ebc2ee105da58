"""Lines for people arrive whole."""

import pytest

from flightsim.autopilot.events import Severity
from flightsim.mavlink.service import Partners
from flightsim.mavlink.statustext import StatustextSender
from tests.flightsim.mavlink.wire import Loop


def _said(text: str) -> list:
    loop, partners = Loop(), Partners()
    partners.channels = [loop.channel]
    StatustextSender(partners).broadcast(Severity.WARNING, text)
    return loop.answers()


@pytest.mark.parametrize("length", [0, 1, 50])
def test_short_lines_are_one_message(length):
    (message,) = _said("x" * length)
    assert (message.text, message.id, message.severity) == ("x" * length, 0, 4)


@pytest.mark.parametrize("length", [51, 99, 100, 101, 250])
def test_long_lines_come_in_chunks_that_end_with_one_that_is_not_full(length):
    text = "".join(chr(97 + index % 26) for index in range(length))
    messages = _said(text)
    assert "".join(message.text for message in messages) == text
    assert len({message.id for message in messages}) == 1
    assert messages[0].id != 0
    assert [message.chunk_seq for message in messages] == list(range(len(messages)))
    assert all(len(message.text) == 50 for message in messages[:-1])
    assert len(messages[-1].text) < 50


def test_endless_lines_are_cut():
    assert len("".join(message.text for message in _said("x" * 5000))) == 250
