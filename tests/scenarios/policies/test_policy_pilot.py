"""Policies in trials: they fly the part that they were trained for, and the verdict is the house's.

Field of our own weights, so that a failure is the pilot's and not a training's.
"""

import numpy as np
import pytest

from scenarios.campaigns.campaign import CampaignError, open_campaign
from scenarios.campaigns.flyer import Flyer, Suite, Trial
from scenarios.environments import AeroSceneEnv
from scenarios.policies import agent as agents
from scenarios.policies.policy import read_policy
from scenarios.tasks.recipe import Recipe
from tests.scenarios.policies.hand_made import CFG, ESTIMATED, write_policy

CALM = Recipe(wind_mps=(0.0, 0.0))


def fly(path, trial=0):
    with Flyer(Suite(recipe=CALM, pilot=f"policy:{path}")) as flyer:
        return flyer.fly(Trial("field", "iris", trial))


def test_a_policy_that_lands_is_judged_as_our_pilot_is_and_repeats_to_the_bit(tmp_path):
    path = write_policy(tmp_path / "p.zip")
    first, again = fly(path), fly(path)
    assert first["code"] == "landed", first["reason"]
    assert first["touchdown_error_m"] < 0.3
    assert first["state_hash"] == again["state_hash"]


def test_a_policy_that_flees_fails_its_trial(tmp_path):
    row = fly(write_policy(tmp_path / "p.zip", sign=-1.0))
    assert row["success"] is False


@pytest.mark.parametrize("task", ["hover", "navigation"])
def test_other_tasks_are_flown_to_the_ground_too(tmp_path, task):
    row = fly(write_policy(tmp_path / "p.zip", task, below_m=0.0))
    assert row["code"] == "landed", row["reason"]


def test_the_policy_sees_what_its_environment_shows(tmp_path, monkeypatch):
    """In the air over the area, a trial's observation is the environment's in the same state."""
    seen, states = [], []
    update = agents.Agent.update

    def watched(self, target_enu_m):
        policy, act = self._policy, self._policy.action
        policy.action = lambda observation: seen.append(observation) or act(observation)
        update(self, target_enu_m)
        policy.action = act
        if len(states) < len(seen):
            states.append((self._observer._fleet.history[:, -1].copy(), target_enu_m))

    monkeypatch.setattr(agents.Agent, "update", watched)
    assert fly(write_policy(tmp_path / "p.zip"))["code"] == "landed"
    env = AeroSceneEnv("landing", "field", CFG)
    env.reset(seed=0)
    observer = env._batch.observer
    for observation, (row, target) in zip(seen[::5], states[::5], strict=True):
        observer._fleet.history[:, -1] = row
        wanted = observer.observe(np.array([target]), np.zeros((1, 4)))[0]
        np.testing.assert_array_equal(observation, wanted)
    env.close()


def test_an_estimate_comes_by_mavlink_and_equals_the_filters(tmp_path, monkeypatch):
    differences = []
    update = agents.Agent.update

    def watched(self, target_enu_m):
        update(self, target_enu_m)
        own = self._observer._fleet.records["filter"]["position_enu_m"][0]
        differences.append(np.abs(np.subtract(self.position_enu_m, own)).max())

    monkeypatch.setattr(agents.Agent, "update", watched)
    row = fly(write_policy(tmp_path / "p.zip", cfg=ESTIMATED))
    assert row["code"] == "landed", row["reason"]
    # MAVLink sends the origin of its frame to the millimetre, and to 1e-7 degrees.
    assert max(differences) < 0.01


def test_an_answer_that_is_no_number_fails_its_trial_alone(tmp_path, monkeypatch):
    path = write_policy(tmp_path / "p.zip")
    policy = read_policy(path)
    monkeypatch.setattr(policy, "_act", lambda _: np.full(4, np.nan))
    monkeypatch.setattr("scenarios.policies.policy.read_policy", lambda _: policy)
    row = fly(path)
    assert row["code"] == "raised"
    assert "action[0] = nan" in row["reason"]


def test_a_campaign_refuses_another_policy_of_the_same_name(tmp_path):
    path = write_policy(tmp_path / "p.zip")
    suite = Suite(pilot=f"policy:{path}")
    with open_campaign(tmp_path / "runs", suite):
        pass
    with open_campaign(tmp_path / "runs", suite):
        pass
    write_policy(path, sign=-1.0)
    with (
        pytest.raises(CampaignError, match="policy_sha256"),
        open_campaign(tmp_path / "runs", suite),
    ):
        pass
