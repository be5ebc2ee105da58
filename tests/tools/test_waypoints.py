"""The client of the ten waypoints, when some of what the stack tells it is lost on the way."""

from types import SimpleNamespace

import pytest
from pymavlink.dialects.v20 import common as mavlink
from waypoints import client as client_module
from waypoints.client import CUSTOMS, Client


class Link:
    """Tells what it is given, one after another, and keeps the commands."""

    target_system = target_component = 1

    def __init__(self, told):
        self._told = list(told)
        self.attempts = []
        self.mav = SimpleNamespace(
            heartbeat_send=lambda *_: None,
            command_long_send=lambda *values: self.attempts.append(values[3]),
        )

    def recv_match(self, **_):
        return self._told.pop(0) if self._told else None


def client_told(*messages):
    client = Client.__new__(Client)
    client._customs, client._link, client._beat_due_s = CUSTOMS["px4"], Link(messages), 0.0
    return client


def reached(number):
    return mavlink.MAVLink_mission_item_reached_message(number)


def current(state):
    return mavlink.MAVLink_mission_current_message(0, mission_state=state)


ACTIVE, COMPLETE = mavlink.MISSION_STATE_ACTIVE, mavlink.MISSION_STATE_COMPLETE


def test_a_mission_is_followed_to_its_last_waypoint():
    numbers = (0, 1, 2, 3, 0, 1, 2)  # 3 is the jump back to the first.
    assert client_told(*map(reached, numbers))._follow(3, laps=2) == 6


def test_a_lost_report_of_a_waypoint_does_not_keep_it_waiting():
    told = (reached(0), current(ACTIVE), reached(2), current(COMPLETE))
    assert client_told(*told)._follow(3, laps=1) == 2


def test_a_command_whose_answer_is_lost_is_said_again(monkeypatch):
    monkeypatch.setattr(client_module, "_ACK_S", 0.01)
    client = client_told()
    monkeypatch.setattr(client, "_wait", answers := Answers())
    assert client._command(400, 1) == mavlink.MAV_RESULT_ACCEPTED
    assert client._link.attempts == [0, 1]
    assert answers.limits_s == [0.01, 0.01]


class Answers:
    """An answer that is lost, and then one that comes."""

    def __init__(self):
        self.limits_s = []

    def __call__(self, kind, is_it, limit_s):
        self.limits_s.append(limit_s)
        if len(self.limits_s) == 1:
            raise client_module.StackError(f"{kind}: not what was waited for")
        answer = mavlink.MAVLink_command_ack_message(400, mavlink.MAV_RESULT_ACCEPTED)
        assert is_it(answer)
        return answer


def test_a_command_that_is_never_answered_is_a_fault(monkeypatch):
    monkeypatch.setattr(client_module, "_ACK_S", 0.0)
    with pytest.raises(client_module.StackError, match="command 400: no answer to 10 tries"):
        client_told()._command(400)
