import os
from importlib.util import find_spec

import numpy as np
import pytest
from gymnasium.spaces import Box

from scenarios.bench import peers
from scenarios.bench.configs import BenchError, WorldsBenchCfg
from scenarios.bench.peers import Peer, peer_rows, stepping_s
from scenarios.bench.worlds import rows


class Countdown:
    """An environment whose episodes end every third step, and that writes as Bullet does."""

    action_space = Box(np.array([0.0, -2.0]), np.array([1.0, 2.0]), dtype=np.float64)

    def __init__(self):
        os.write(1, b"build time: now\n")
        self.said, self.n_resets, self.is_closed = [], 0, False

    def reset(self, *, seed=None):  # noqa: ARG002 - as Gymnasium calls it
        self.n_resets += 1
        self.left = 3
        return 0, {}

    def step(self, action):
        assert self.left > 0, "stepped after the end of an episode"
        self.said.append(action.tolist())
        self.left -= 1
        return 0, 0.0, self.left == 0, False, {}

    def close(self):
        self.is_closed = True


def test_a_peer_is_stepped_through_its_episodes_with_the_middle_of_its_actions():
    countdown = Countdown()
    cpu_s = stepping_s(Peer("x", 10.0, 100.0, lambda: countdown, "", ""), seconds=2.0)
    assert cpu_s > 0.0
    assert countdown.said == [[0.5, 0.0]] * 30  # ten steps to warm up, twenty measured
    assert countdown.n_resets == 11
    assert countdown.is_closed


def test_many_environments_together_are_stepped_on_while_they_reset_themselves():
    class Together(Countdown):
        def step(self, action):
            self.said.append(action.tolist())
            return 0, np.zeros(64), np.ones(64, bool), np.zeros(64, bool), {}

    together = Together()
    assert stepping_s(Peer("x", 10.0, 100.0, lambda: together, "", "", 64), seconds=2.0) > 0.0
    assert len(together.said) == 30
    assert together.n_resets == 1


def test_our_environment_comes_first_and_what_a_peer_writes_stays_off_the_output(
    monkeypatch, capfd
):
    slow = Peer("slow Countdown", 20.0, 240.0, Countdown, "", "")
    monkeypatch.setattr(peers, "PEERS", {"pyflyt": (slow,)})
    found = list(peer_rows(("pyflyt",), 1.0))
    titles = [peer.title for peer in peers.OURS for _ in range(3)]
    assert [row.metric for row in found] == titles + ["slow Countdown"] * 3
    steps, physics, seconds = found[-3:]
    assert steps.unit == "steps of 50 ms / CPU s"
    assert steps.value == pytest.approx(20.0 * seconds.value)
    assert physics.value == pytest.approx(240.0 * seconds.value)
    output = capfd.readouterr()
    assert "build time" not in output.out
    assert "build time" in output.err


@pytest.mark.skipif(find_spec("PyFlyt") is not None, reason="it is installed")
def test_a_peer_that_is_not_installed_is_refused_before_anything_is_flown():
    cfg = WorldsBenchCfg(worlds=2, scenes=("field",), seconds=1.0, peers=("pyflyt",))
    with pytest.raises(BenchError, match=r"peers: PyFlyt cannot be had .*; valid: pip install"):
        next(iter(rows(cfg, lambda *_: None)))


def test_a_peer_without_what_it_needs_is_refused_by_the_name_of_that(monkeypatch):
    def make():
        raise ModuleNotFoundError("No module named 'pkg_resources'")

    absent = Peer("PyFlyt x", 40.0, 240.0, make, "", "its source")
    monkeypatch.setattr(peers, "PEERS", {"pyflyt": (absent,)})
    with pytest.raises(BenchError, match=r"peers: PyFlyt .*pkg_resources.*; valid: its source"):
        list(peer_rows(("pyflyt",), 1.0))
