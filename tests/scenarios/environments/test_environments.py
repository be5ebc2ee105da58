"""Environments as Gymnasium and Stable-Baselines3 see them, and their determinism."""

import hashlib
import math
import re
from pathlib import Path

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from stable_baselines3.common.env_checker import check_env as stable_baselines_check

from scenarios.environments import (
    AeroSceneEnv,
    AeroSceneVectorEnv,
    EnvironmentCfg,
    EnvironmentInputError,
    ObservationCfg,
    RandomisationCfg,
)

NAMES = ("AeroScene/Hover-v0", "AeroScene/Navigation-v0", "AeroScene/Landing-v0")
EVERYTHING = EnvironmentCfg(
    action="motors",
    episode_s=1.0,
    observation=ObservationCfg(
        state="estimated",
        imu=True,
        range=True,
        last_action=True,
        depth=(12, 8),
        segments=("classes", "objects"),
    ),
    randomisation=RandomisationCfg(mass=0.2, rotors=0.1, wind_mps=5.0, latency_s=0.06),
)
NOISY = EnvironmentCfg(
    action="velocity",
    episode_s=1.0,
    randomisation=RandomisationCfg(mass=0.1, noise=2.0, wind_mps=3.0, latency_s=0.1),
)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("cfg", [None, EVERYTHING], ids=["default", "everything"])
def test_gymnasium_finds_no_fault(name, cfg):
    env = gymnasium.make(name, cfg=cfg)
    check_env(env.unwrapped)
    env.close()


@pytest.mark.parametrize("name", NAMES)
def test_stable_baselines_finds_no_fault(name):
    env = gymnasium.make(name)
    stable_baselines_check(env.unwrapped)
    env.close()


def digest(observation):
    parts = observation.values() if isinstance(observation, dict) else [observation]
    return [hashlib.sha256(np.ascontiguousarray(part).tobytes()).hexdigest() for part in parts]


def flights(n_worlds, n_threads, cfg, n_steps=70):
    """What each world of a vector environment goes through, with ends and new beginnings."""
    env = AeroSceneVectorEnv("hover", n_worlds, ("field", "42"), cfg, n_threads)
    observations, _ = env.reset(seed=5)
    rngs = [np.random.default_rng(i) for i in range(n_worlds)]
    seen = [[] for _ in range(n_worlds)]
    for _ in range(n_steps):
        actions = np.stack([0.3 * rng.standard_normal(4) for rng in rngs])
        observations, reward, is_terminated, is_truncated, _ = env.step(actions)
        for i in range(n_worlds):
            own = (
                {name: part[i] for name, part in observations.items()}
                if isinstance(observations, dict)
                else observations[i]
            )
            seen[i].append((digest(own), reward[i], is_terminated[i] or is_truncated[i]))
    env.close()
    return seen


@pytest.mark.parametrize("cfg", [NOISY, EVERYTHING], ids=["noisy", "everything"])
def test_a_world_is_the_same_among_few_and_many_on_one_thread_or_more(cfg):
    many = flights(8, 3, cfg)
    assert many == flights(8, 1, cfg)
    assert many[:3] == flights(3, 2, cfg)
    assert sum(is_over for _, _, is_over in many[0]) >= 1


@pytest.mark.parametrize("cfg", [NOISY, EVERYTHING], ids=["noisy", "everything"])
def test_a_world_alone_is_the_same_as_among_others(cfg):
    env = AeroSceneEnv("hover", "42", cfg)
    observation, _ = env.reset(seed=6)  # the second world's
    rng, alone = np.random.default_rng(1), []
    for _ in range(70):
        observation, reward, is_terminated, is_truncated, _ = env.step(0.3 * rng.standard_normal(4))
        is_over = is_terminated or is_truncated
        if is_over:
            observation, _ = env.reset()
        alone.append((digest(observation), reward, is_over))
    env.close()
    assert alone == flights(2, 1, cfg)[1]
    assert any(is_over for _, _, is_over in alone)


def test_another_seed_is_another_episode():
    env = AeroSceneEnv("hover")
    first, again, other = (env.reset(seed=seed)[0] for seed in (1, 1, 2))
    np.testing.assert_array_equal(first, again)
    assert np.abs(first - other).max() > 0.05
    assert np.abs(env.reset()[0] - other).max() > 0.05
    env.close()


def test_make_vec_makes_the_native_kind_over_several_scenes():
    env = gymnasium.make_vec(NAMES[0], num_envs=3, scenes=("field", "42"), n_threads=2)
    assert isinstance(env.unwrapped, AeroSceneVectorEnv)
    observations, _ = env.reset(seed=0)
    assert env.observation_space.contains(observations)
    observations, reward, is_terminated, is_truncated, info = env.step(np.zeros((3, 4)))
    assert env.observation_space.contains(observations)
    assert reward.shape == is_terminated.shape == is_truncated.shape == info["distance_m"].shape
    env.close()


def test_the_last_step_tells_of_the_end_and_begins_anew():
    env = AeroSceneVectorEnv("hover", 2, cfg=EnvironmentCfg(action="position", episode_s=1.0))
    observations, _ = env.reset(seed=0)
    for _ in range(50):
        actions = np.zeros((2, 4))
        actions[:, :3] = np.clip(0.5 * observations[:, :3], -1.0, 1.0)
        observations, _, is_terminated, is_truncated, info = env.step(actions)
    assert is_truncated.all()
    assert not is_terminated.any()
    before_m = [np.linalg.norm(last[:3]) for last in info["final_obs"]]
    np.testing.assert_allclose(before_m, info["distance_m"], atol=1e-3)
    assert np.abs(observations[0, :3] - info["final_obs"][0][:3]).max() > 0.05
    assert info["final_info"]["code"][0] in {"done", "gave_up"}
    env.close()


def test_the_last_images_are_those_of_the_end():
    env = AeroSceneVectorEnv("hover", 2, ("42",), EVERYTHING, n_threads=1)
    env.reset(seed=0)
    is_over = False
    while not is_over:
        observations, _, is_terminated, is_truncated, info = env.step(np.zeros((2, 4)))
        is_over = is_terminated[0] or is_truncated[0]
    for name in ("depth", *EVERYTHING.observation.segments):
        before, after = info["final_obs"][0][name], observations[name][0]
        assert before.shape == after.shape
        assert (before != after).mean() > 0.1
    env.close()


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (
            lambda: EnvironmentCfg(action="thrust"),
            r"action = 'thrust': motors, rates, attitude, velocity, pos",
        ),
        (
            lambda: EnvironmentCfg(action_hz=60),
            r"action_hz = 60: 250, 125, 50, 25, 10, 5 are valid",
        ),
        (
            lambda: EnvironmentCfg(hz=50),
            r"hz = 50: it is unknown; vehicle, action, action_hz, episode_s, observation, random",
        ),
        (
            lambda: ObservationCfg(rgb=True),
            r"observation\.rgb = True: it is unknown; state, target",
        ),
        (
            lambda: RandomisationCfg(gusts=1.0),
            r"randomisation\.gusts = 1\.0: it is unknown; mass, rotors, wind_mps, noise, latency_s",
        ),
        (lambda: EnvironmentCfg(episode_s=math.nan), r"episode_s = nan: 1 to 600 are valid"),
        (
            lambda: ObservationCfg(state="best"),
            r"observation\.state = 'best': true, estimated, none",
        ),
        (lambda: ObservationCfg(depth=(64, 4)), r"observation\.depth = \(64, 4\): None, or width"),
        (lambda: ObservationCfg(state="none", target=False), r"observation: it has no part"),
        (lambda: RandomisationCfg(mass=0.9), r"randomisation\.mass = 0\.9: 0 to 0\.5 are valid"),
        (
            lambda: AeroSceneEnv("hover", cfg={"a": 1}),
            r"cfg = \{'a': 1\}: an EnvironmentCfg is valid",
        ),
        (
            lambda: EnvironmentCfg(observation=3),
            r"observation = 3: ObservationCfg\(\.\.\.\) is valid",
        ),
        (lambda: AeroSceneEnv("race"), r"task = 'race': hover, navigation, landing are valid"),
        (lambda: AeroSceneVectorEnv("hover", 0), r"num_envs = 0: 1 or more are valid"),
        (lambda: AeroSceneVectorEnv("hover", 2, "42"), r"scenes = '42': a sequence such as"),
        (
            lambda: AeroSceneVectorEnv("hover", 2, n_threads=0),
            r"n_threads = 0: 1 or more are valid",
        ),
    ],
)
def test_a_configuration_that_is_not_valid_is_refused_in_one_line(make, says):
    with pytest.raises(EnvironmentInputError, match=says) as raised:
        make()
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize(
    ("action", "says"),
    [
        (np.zeros(3), r"action: its shape is \(3,\); numbers of -1 to 1 in shape \(4,\) are valid"),
        (np.array([0, 0, math.nan, 0]), r"action\[2\] = nan: finite numbers of -1 to 1 are valid"),
        ("up", r"action = 'up': numbers of -1 to 1 in an array of shape \(4,\) are valid"),
    ],
)
def test_an_action_that_is_not_valid_is_refused_and_nothing_moves(action, says):
    env = AeroSceneEnv("hover")
    with pytest.raises(EnvironmentInputError, match=r"only reset\(\) is valid"):
        env.step(np.zeros(4))
    env.reset(seed=0)
    with pytest.raises(EnvironmentInputError, match=says):
        env.step(action)
    flown, _, _, _, _ = env.step(np.zeros(4))
    env.reset(seed=0)
    np.testing.assert_array_equal(flown, env.step(np.zeros(4))[0])
    with pytest.raises(EnvironmentInputError, match="options"):
        env.reset(options={"wind": 3})
    env.close()


def test_the_snippets_of_the_page_run_from_top_to_bottom():
    page = (Path(__file__).parents[3] / "docs" / "learning.md").read_text()
    names = {}
    for block in re.findall(r"```python\n(.*?)```", page, re.DOTALL):
        exec(compile(block, "docs/learning.md", "exec"), names)
    assert names["observation"].shape == (18,)
    assert names["infos"]["distance_m"].shape == (8,)
    assert (names["infos"]["distance_m"] < 5.0).all()


def test_seeds_are_one_for_each_world():
    env = AeroSceneVectorEnv("hover", 2)
    with pytest.raises(EnvironmentInputError, match="seed: 3 numbers for 2 worlds"):
        env.reset(seed=[1, 2, 3])
    env.close()


@pytest.mark.parametrize("name", NAMES)
def test_every_environment_returns_pictures_of_the_vehicle(name):
    env = gymnasium.make(name, render_mode="rgb_array")
    env.reset(seed=1)
    first = env.render()
    assert (first.shape, first.dtype) == ((480, 640, 3), np.uint8)
    assert first.std() > 10
    for _ in range(10):
        env.step(np.array([0.3, 0.0, 0.3, 0.0], dtype=np.float32))
    assert (env.render() != first).any()
    assert env.unwrapped.metadata["render_fps"] == 50
    env.close()


def test_a_vector_of_worlds_returns_a_picture_of_each():
    envs = gymnasium.make_vec(
        "AeroScene/Hover-v0", num_envs=2, scenes=("field", "42"), render_mode="rgb_array"
    )
    envs.reset(seed=1)
    first, second = envs.render()
    assert first.shape == second.shape == (480, 640, 3)
    assert (first != second).any()
    envs.close()


def test_pictures_change_no_episode():
    flights = []
    for mode in (None, "rgb_array"):
        env = gymnasium.make("AeroScene/Landing-v0", cfg=NOISY, render_mode=mode)
        seen = [env.reset(seed=4)[0]]
        for _ in range(20):
            seen.append(env.step(np.array([0.2, 0.1, -0.1, 0.3], dtype=np.float32))[0])
            env.render()
        flights.append(np.array(seen))
        env.close()
    np.testing.assert_array_equal(*flights)


def test_gymnasiums_recorder_gets_every_frame(tmp_path):
    """`RecordVideo` itself needs moviepy, which wants an older Pillow than ours."""
    from gymnasium.wrappers import RenderCollection

    env = RenderCollection(gymnasium.make("AeroScene/Hover-v0", render_mode="rgb_array"))
    env.reset(seed=0)
    for _ in range(3):
        env.step(np.zeros(4, dtype=np.float32))
    frames = env.render()
    assert [frame.shape for frame in frames] == [(480, 640, 3)] * 4
    env.close()


def test_a_mode_that_is_none_and_a_picture_before_the_first_episode_are_refused():
    with pytest.raises(EnvironmentInputError, match="None and 'rgb_array' are valid"):
        AeroSceneEnv("hover", render_mode="human")
    env = AeroSceneEnv("hover", render_mode="rgb_array")
    with pytest.raises(EnvironmentInputError, match="before the first episode"):
        env.render()
    env.close()
    env = AeroSceneEnv("hover")
    env.reset(seed=0)
    assert env.render() is None
    env.close()
