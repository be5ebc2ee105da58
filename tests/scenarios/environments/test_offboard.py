"""Environments that a whole autopilot flies: actions are setpoints of MAVLink."""

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from scenarios.environments import (
    AutopilotCfg,
    EnvironmentCfg,
    EnvironmentInputError,
    ObservationCfg,
    RandomisationCfg,
    autopilots,
)

NAME = "AeroScene/Offboard-v0"
SHORT = {"episode_s": 1.0}


def to_target(level, observation):
    """An action that leads to the target at each level; the observation begins with the way."""
    way, velocity = observation[:3], observation[3:6]
    if level == "velocity":
        return np.clip([*(way * (0.2, 0.2, 0.33)), 0.0], -1.0, 1.0)
    if level == "position":
        return np.clip([*(0.4 * way), 0.0], -1.0, 1.0)
    # By attitude: lean towards the target as a damped spring would, in the vehicle's heading.
    wanted = 1.0 * way - 1.4 * velocity
    rotation = observation[6:15].reshape(3, 3)
    yaw = np.arctan2(rotation[1, 0], rotation[0, 0])
    forward = wanted[0] * np.cos(yaw) + wanted[1] * np.sin(yaw)
    left = wanted[1] * np.cos(yaw) - wanted[0] * np.sin(yaw)
    roll, pitch = np.clip([-left / 9.8, forward / 9.8], -0.35, 0.35)
    thrust = np.clip(0.12 * wanted[2], -1.0, 1.0)
    if level == "attitude":
        return np.clip([thrust, roll / 0.6, pitch / 0.6, 0.0], -1.0, 1.0)
    now_roll = np.arctan2(rotation[2, 1], rotation[2, 2])
    now_pitch = -np.arcsin(np.clip(rotation[2, 0], -1.0, 1.0))
    rates = 4.0 * np.array([roll - now_roll, pitch - now_pitch])
    return np.clip([thrust, *(rates / 6.0), 0.0], -1.0, 1.0)


@pytest.mark.parametrize("level", ["velocity", "position", "attitude", "rates"])
def test_each_kind_of_setpoint_brings_the_vehicle_to_its_target(level):
    env = gymnasium.make(NAME, cfg=EnvironmentCfg(action=level, episode_s=6.0))
    observation, info = env.reset(seed=3)
    first_m, is_over = np.linalg.norm(observation[:3]), False
    while not is_over:
        observation, _, terminated, truncated, info = env.step(to_target(level, observation))
        is_over = terminated or truncated
    env.close()
    assert first_m > 0.5
    assert truncated, info
    assert info["distance_m"] < 0.25, info


def test_gymnasium_finds_no_fault():
    env = gymnasium.make(NAME, cfg=EnvironmentCfg(action="velocity", action_hz=10, **SHORT))
    check_env(env.unwrapped, skip_render_check=True)
    env.close()


def test_a_seed_repeats_its_episode_alone_and_among_others():
    cfg = EnvironmentCfg(
        action="velocity",
        action_hz=10,
        observation=ObservationCfg(state="estimated"),
        randomisation=RandomisationCfg(wind_mps=4.0, latency_s=0.2),
        **SHORT,
    )
    alone = gymnasium.make(NAME, cfg=cfg)
    together = gymnasium.make_vec(NAME, num_envs=2, cfg=cfg)
    first, _ = alone.reset(seed=6)
    both, _ = together.reset(seed=5)
    np.testing.assert_array_equal(both[1], first)
    action = np.array([0.3, -0.2, 0.1, 0.2], dtype=np.float32)
    for _ in range(5):
        observation, *_ = alone.step(action)
        both, *_ = together.step(np.stack([action, action]))
        np.testing.assert_array_equal(both[1], observation)
    assert not np.array_equal(both[0], both[1])
    alone.close()
    together.close()


def test_a_landing_is_judged_as_in_a_trial():
    env = gymnasium.make(NAME, task="landing", cfg=EnvironmentCfg(action="velocity", action_hz=10))
    observation, _ = env.reset(seed=0)
    is_over = False
    while not is_over:
        way = observation[:3] - (0.0, 0.0, 0.3)
        speed = np.tanh(way * (0.8, 0.8, 2.0)) * (0.4, 0.4, 0.2)
        observation, _, terminated, truncated, info = env.step(np.array([*speed, 0.0]))
        is_over = terminated or truncated
    env.close()
    assert info["code"] == "landed", info


def test_a_setpoint_passes_through_the_autopilots_limits():
    """The plant's own controller would follow 3 m/s upwards; a lower limit of MAVLink's holds."""
    env = gymnasium.make(NAME, cfg=EnvironmentCfg(action="velocity", action_hz=10, episode_s=2.0))
    env.reset(seed=0)
    seat = env.unwrapped._batch._fleet._seat(0)
    seat._vehicle.autopilot.parameters.set("MPC_Z_VEL_MAX_UP", 0.5)
    for _ in range(12):
        observation, *_ = env.step(np.array([0.0, 0.0, 1.0, 0.0]))
    env.close()
    assert 0.3 < observation[5] < 0.6


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        ({"cfg": EnvironmentCfg(action="motors")}, "action = 'motors'"),
        ({"cfg": EnvironmentCfg(action="rates", action_hz=250)}, "action_hz = 250"),
        (
            {"cfg": EnvironmentCfg(randomisation=RandomisationCfg(mass=0.1))},
            "randomisation.mass = 0.1",
        ),
        ({"task": "landing", "autopilot": AutopilotCfg(name="px4", binary="px4")}, "task = 'land"),
        ({"task": "swim"}, "task = 'swim'"),
    ],
)
def test_what_an_autopilot_does_not_allow_is_refused_in_one_line(options, reason):
    with pytest.raises(EnvironmentInputError, match=reason) as caught:
        gymnasium.make(NAME, **options)
    assert "\n" not in str(caught.value)


def test_an_autopilot_that_does_not_take_off_says_so(monkeypatch):
    monkeypatch.setattr(autopilots, "_LIFT_MPS", 0.0)
    monkeypatch.setattr(autopilots, "_LONGEST_S", 5.0)
    env = gymnasium.make(NAME, cfg=EnvironmentCfg(action="velocity"))
    with pytest.raises(autopilots.AutopilotError, match="does not take off"):
        env.reset(seed=0)
    env.close()
