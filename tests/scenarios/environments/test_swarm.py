"""`AeroScene/Swarm-v0` as PettingZoo sees it, its determinism and its ends."""

import hashlib
import re
import warnings

import numpy as np
import pytest
from pettingzoo.test import parallel_api_test

from flightsim.vehicles.catalogue import airframe_by_name
from scenarios.environments import (
    EnvironmentCfg,
    EnvironmentInputError,
    ObservationCfg,
    RandomisationCfg,
    swarm_v0,
)
from scenarios.environments.tasks.swarm import nearest_mate_m

EVERYTHING = EnvironmentCfg(
    action="rates",
    episode_s=1.0,
    observation=ObservationCfg(
        state="estimated",
        imu=True,
        range=True,
        last_action=True,
        depth=(24, 18),
        segments=("classes", "objects"),
    ),
    randomisation=RandomisationCfg(mass=0.2, rotors=0.1, wind_mps=3.0, noise=1.0, latency_s=0.06),
)


@pytest.fixture(scope="module")
def steered():
    """Four vehicles that take velocities."""
    env = swarm_v0.parallel_env(4, cfg=EnvironmentCfg(action="velocity", episode_s=6.0))
    yield env
    env.close()


@pytest.mark.parametrize("cfg", [EnvironmentCfg(episode_s=1.0), EVERYTHING], ids=["default", "all"])
def test_pettingzoo_finds_no_fault(cfg):
    env = swarm_v0.parallel_env(["iris", "hummingbird"], cfg=cfg)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        parallel_api_test(env, num_cycles=60)
    env.close()


def digest(env, seed, n_steps=30):
    sha, rng = hashlib.sha256(), np.random.default_rng(0)
    observations, _ = env.reset(seed=seed)
    for _ in range(n_steps):
        for agent in sorted(observations):
            sha.update(b"".join(part.tobytes() for part in observations[agent].values()))
        sha.update(env.history.tobytes())
        if not env.agents:
            break
        actions = {agent: rng.uniform(-1.0, 1.0, 4) for agent in env.agents}
        observations, *_ = env.step(actions)
    return sha.hexdigest()


def test_the_same_seed_is_the_same_episode_bit_for_bit():
    first, second = (swarm_v0.parallel_env(["iris", "hummingbird"], cfg=EVERYTHING) for _ in "ab")
    again = digest(first, 5)
    assert digest(second, 4) != again
    assert digest(second, 5) == again
    assert digest(first, 5) == again


def to_target(observation):
    """Velocity towards the target, whose way is the first part of an observation."""
    return np.clip([*(0.8 * observation[:3] / (5.0, 5.0, 3.0)), 0.0], -1.0, 1.0)


def test_who_flies_to_the_targets_without_contact_succeeds(steered):
    observations, _ = steered.reset(seed=1)
    ends = {}
    while steered.agents:
        actions = {agent: to_target(observations[agent]) for agent in steered.agents}
        observations, _, terminated, truncated, infos = steered.step(actions)
        ends |= {a: infos[a] for a in infos if terminated[a] or truncated[a]}
    assert {end["code"] for end in ends.values()} == {"done"}
    assert len(ends) == 4


def test_who_meets_another_ends_and_falls_and_the_others_fly_on(steered):
    observations, _ = steered.reset(seed=1)
    ended = {}
    while steered.agents and not ended:
        # The first two fly at each other: the second is the first mate of the first.
        actions = dict.fromkeys(steered.agents, np.zeros(4))
        for agent, sign in (("vehicle_1", 1.0), ("vehicle_2", -1.0)):
            towards = observations["vehicle_1"][-18:-15]
            actions[agent] = np.append(np.clip(sign * towards, -1.0, 1.0), 0.0)
        observations, rewards, terminated, _, infos = steered.step(actions)
        ended = {agent for agent, is_over in terminated.items() if is_over}
    assert ended == {"vehicle_1", "vehicle_2"}
    assert rewards["vehicle_1"] < -4.0
    assert infos["vehicle_1"]["is_success"] is False
    assert steered.agents == ["vehicle_3", "vehicle_4"]
    height_m = steered.history["position_true_enu_m"][0, -1, 2]
    for _ in range(25):
        steered.step(dict.fromkeys(steered.agents, np.zeros(4)))
    assert steered.history["position_true_enu_m"][0, -1, 2] < height_m - 0.5
    assert steered.agents == ["vehicle_3", "vehicle_4"]


def test_the_nearest_mate_of_each_vehicle():
    places = np.array([[0.0, 0.0, 0.0], [3.0, 4.0, 0.0], [0.0, 0.0, 1.0]])
    assert nearest_mate_m(places).tolist() == pytest.approx([1.0, 5.0, 1.0])


@pytest.mark.parametrize(
    ("vehicles", "cfg", "says"),
    [
        (1, EnvironmentCfg(), "vehicles = 1: 2 to 16"),
        ("iris", EnvironmentCfg(), "vehicles = 'iris': 2 to 16"),
        (["iris", "typhoon"], EnvironmentCfg(), "the same number of rotors are valid"),
    ],
)
def test_bad_input_is_refused_in_a_line(vehicles, cfg, says):
    with pytest.raises(EnvironmentInputError, match=re.escape(says)):
        swarm_v0.parallel_env(vehicles, cfg=cfg)


def test_vehicles_see_each_other_where_they_are():
    sees = ObservationCfg(state="none", target=False, depth=(64, 48), segments=("objects",))
    env = swarm_v0.parallel_env(2, cfg=EnvironmentCfg(action="velocity", observation=sees))
    env.reset(seed=3)
    fov_rad = airframe_by_name("iris").cameras[0].vertical_fov_rad
    rows, columns = np.indices((48, 64))
    off_axis = np.hypot(rows - 23.5, columns - 31.5) / (24.0 / np.tan(0.5 * fov_rad))
    n_seen = 0
    for _ in range(40):
        actions = dict.fromkeys(env.agents, np.array([0.0, 0.0, 0.0, 0.5]))  # look around
        seen, *_ = env.step(actions)
        for agent, mate in (("vehicle_1", -101), ("vehicle_2", -100)):
            assert env.observation_space(agent).contains(seen[agent])
            is_mate = seen[agent]["objects"] == mate
            away_m = np.linalg.norm(seen[agent]["numbers"][:3])
            if is_mate.any():
                n_seen += 1
                found_m = (seen[agent]["depth"] * np.hypot(1.0, off_axis))[is_mate]
                assert abs(np.median(found_m) - away_m) < 0.4
    assert n_seen > 5
    env.close()


def test_a_missing_action_is_refused(steered):
    steered.reset(seed=0)
    with pytest.raises(EnvironmentInputError, match="actions: vehicle_1 has none"):
        steered.step({"vehicle_2": np.zeros(4)})
    with pytest.raises(EnvironmentInputError, match="its shape is"):
        steered.step(dict.fromkeys(steered.agents, np.zeros(3)))


def test_a_picture_shows_all_vehicles_and_changes_nothing():
    env = swarm_v0.parallel_env(vehicles=3, render_mode="rgb_array")
    env.reset(seed=2)
    first = env.render()
    assert (first.shape, first.dtype) == ((480, 640, 3), np.uint8)
    assert env.metadata["render_fps"] == 50
    env.step({agent: np.full(4, 0.2, dtype=np.float32) for agent in env.agents})
    assert (env.render() != first).any()
    env.close()
