"""What agents see and command, what is drawn for an episode, and how it ends."""

import math
from dataclasses import replace

import numpy as np
import pytest

from aeroscene.sources import load_scene
from flightsim.vehicles.catalogue import airframe_by_name
from scenarios.environments import (
    EnvironmentCfg,
    EnvironmentInputError,
    ObservationCfg,
    RandomisationCfg,
)
from scenarios.environments.batch import Batch
from scenarios.environments.tasks import task_by_name
from tests.flightsim.handmade import empty_scene
from tests.scenarios.landing_scenes import ON_LAWN, thing, yard


def begun(task, cfg=None, *, n=1, scenes=None):
    batch = Batch(task_by_name(task), scenes or ["field"] * n, cfg, n_threads=1)
    for i in range(len(batch)):
        batch.seed(i, i)
    batch.begin(range(len(batch)))
    return batch


def fly(batch, law, seconds):
    """Fly by a law of the observations until the first episode ends."""
    for _ in range(round(seconds * 50)):
        step = batch.step(law(batch.observe()))
        if 0 in step.outcomes:
            return step, step.outcomes[0].judgement
    return step, None


def to_target(observations):
    actions = np.zeros((len(observations), 4))
    actions[:, :3] = np.clip(0.3 * observations[:, :3], -1.0, 1.0)
    return actions


@pytest.mark.parametrize(
    ("level", "action", "measure", "wanted", "tolerance"),
    [
        ("velocity", (0.2, -0.1, 0.1, 0.0), "velocity_true_enu_mps", (1.0, -0.5, 0.3), 0.05),
        ("velocity", (0.0, 0.0, 0.0, 0.4), "angular_rate_true_flu_radps", (0.0, 0.0, 0.6), 0.05),
        ("rates", (0.0, 0.0, 0.0, 0.3), "angular_rate_true_flu_radps", (0.0, 0.0, 0.9), 0.1),
    ],
)
def test_an_action_commands_what_its_level_says(level, action, measure, wanted, tolerance):
    batch = begun("hover", EnvironmentCfg(action=level))
    for _ in range(75):
        batch.step(np.array([action]))
    np.testing.assert_allclose(batch.history[measure][0, -1], wanted, atol=tolerance)


def test_motors_at_zero_carry_the_weight_and_at_minus_one_stand():
    batch = begun("hover", EnvironmentCfg(action="motors"))
    batch.step(np.zeros((1, 4)))
    row = batch.history[0, -1]
    rotors = airframe_by_name("iris").quadrotor
    lift_n = sum(
        rotor.thrust_constant * speed**2
        for rotor, speed in zip(rotors.rotors, row["rotor_speed_radps"], strict=True)
    )
    assert lift_n == pytest.approx(rotors.mass_kg * 9.80665, rel=0.01)
    batch.step(np.array([[1.0, 1.0, 1.0, -1.0]]))
    commands = batch.history[0, -1]["rotor_command_radps"]
    assert commands[0] == pytest.approx(rotors.rotors[0].max_speed_radps)
    assert commands[3] == 0.0


def test_the_faster_the_actions_the_shorter_the_step():
    for hz in (250, 10):
        batch = begun("hover", EnvironmentCfg(action_hz=hz, action="velocity"))
        batch.step(np.zeros((1, 4)))
        assert batch.history["time_us"][0, -1] == 1_000_000 // hz


def test_an_observation_has_the_parts_that_were_asked_for():
    cfg = ObservationCfg(state="true", target=True, imu=True, range=True, last_action=True)
    batch = begun("hover", EnvironmentCfg(action="velocity", observation=cfg))
    for _ in range(50):
        batch.step(np.array([[0.1, 0.0, 0.0, 0.0]]))
    (seen,) = batch.observe()
    row = batch.history[0, -1]
    np.testing.assert_allclose(seen[3:6], row["velocity_true_enu_mps"], rtol=1e-5)
    np.testing.assert_allclose(
        seen[6:15].reshape(3, 3) @ seen[6:15].reshape(3, 3).T, np.eye(3), atol=1e-5
    )
    np.testing.assert_allclose(seen[15:18], row["angular_rate_true_flu_radps"], atol=1e-5)
    np.testing.assert_allclose(seen[18:22], (0.1, 0.0, 0.0, 0.0), atol=1e-6)
    assert seen[24] == pytest.approx(9.8, abs=1.0)  # the accelerometer's upward axis
    ground_m = row["position_true_enu_m"][2]
    assert seen[28] == pytest.approx(ground_m, abs=0.2)


def test_an_estimated_state_errs_a_little():
    cfg = EnvironmentCfg(action="velocity", observation=ObservationCfg(state="estimated"))
    batch = begun("hover", cfg)
    errors_m = []
    for _ in range(100):
        batch.step(np.zeros((1, 4)))
        row = batch.history[0, -1]
        errors_m.append(math.dist(row["position_est_enu_m"], row["position_true_enu_m"]))
    assert 0.005 < np.mean(errors_m) < 1.0


def test_an_episode_differs_from_the_next_as_configured():
    drawn = RandomisationCfg(mass=0.3, rotors=0.2, wind_mps=8.0)
    batch = begun("hover", EnvironmentCfg(randomisation=drawn), n=12)
    fleet = batch._fleet
    masses = [w.model.body_mass[w.vehicle_body_id] / 1.5 for w in fleet.worlds]
    assert min(masses) < 0.85
    assert max(masses) > 1.15
    assert np.ptp(fleet.records["rotors"]["effectiveness"]) > 0.25
    assert np.ptp(np.linalg.norm(fleet.records["rotors"]["wind_enu_mps"], axis=1)) > 3.0
    assert len({w.model for w in begun("hover", n=3)._fleet.worlds}) == 1


def test_noise_is_on_what_is_seen_and_not_on_what_is_flown():
    quiet, noisy = (
        begun(
            "hover", EnvironmentCfg(randomisation=RandomisationCfg(noise=noise), action="velocity")
        )
        for noise in (0.0, 5.0)
    )
    seen = []
    for batch in (quiet, noisy):
        for _ in range(20):
            batch.step(np.zeros((1, 4)))
        seen.append(batch.observe())
    np.testing.assert_array_equal(
        quiet.history["velocity_true_enu_mps"], noisy.history["velocity_true_enu_mps"]
    )
    errors = np.abs(seen[0] - seen[1])[0]
    for first, last in ((0, 3), (3, 6), (6, 15), (15, 18)):
        assert 1e-5 < errors[first:last].max() < 2.0


def test_latency_delays_what_actions_do():
    batch = begun("hover", EnvironmentCfg(randomisation=RandomisationCfg(latency_s=0.1)), n=8)
    up = np.tile([1.0, 0.0, 0.0, 0.0], (8, 1))
    heard = np.full(8, -1)
    for k in range(8):
        batch.step(up)
        thrust = batch._fleet.setpoints["thrust"]
        heard = np.where((heard < 0) & (thrust > 0.99), k, heard)
    assert heard.min() >= 0
    assert heard.max() <= 5
    assert len(set(heard.tolist())) > 1


def test_hover_is_done_when_the_target_was_held():
    step, judgement = fly(begun("hover", EnvironmentCfg(action="velocity")), to_target, 11.0)
    assert judgement.code == "done"
    assert step.is_truncated[0]
    assert not step.is_terminated[0]


def test_who_falls_has_crashed():
    def nothing(observations):
        return np.tile([-1.0, 0.0, 0.0, 0.0], (len(observations), 1))

    for task in ("hover", "navigation"):
        step, judgement = fly(begun(task), nothing, 3.0)
        assert judgement.code in {"contact", "fell_over", "never_flew"}
        assert step.is_terminated[0]
        assert step.reward[0] < -4.0


def test_navigation_is_done_at_the_target():
    step, judgement = fly(begun("navigation", EnvironmentCfg(action="velocity")), to_target, 20.0)
    assert judgement.code == "done"
    assert step.is_terminated[0]
    assert step.reward[0] > 9.0


def test_navigation_into_a_wall_is_a_contact():
    scene = load_scene("42")
    batch = begun("navigation", EnvironmentCfg(action="velocity"), scenes=[scene])

    def sideways(observations):
        return np.tile([1.0, 0.0, -0.05, 0.0], (len(observations), 1))

    _, judgement = fly(batch, sideways, 30.0)
    assert judgement.code in {"contact", "fell_over"}


@pytest.mark.parametrize(("descent", "code"), [(0.2, "landed"), (0.8, "hard_touchdown")])
def test_landing_is_judged_as_a_trial_is(descent, code):
    def down(observations):
        actions = to_target(observations)
        actions[:, 2] = -descent
        return actions

    step, judgement = fly(begun("landing", EnvironmentCfg(action="velocity")), down, 20.0)
    assert judgement.code == code
    assert step.is_terminated[0]
    assert (step.reward[0] > 9.0) == (code == "landed")


def test_each_world_is_judged_by_its_own_flight():
    batch, codes = begun("landing", EnvironmentCfg(action="velocity"), n=2), {}
    while len(codes) < 2:
        actions = to_target(batch.observe())
        actions[:, 2] = (-0.8, -0.2)
        for i, outcome in batch.step(actions).outcomes.items():
            codes.setdefault(i, outcome.judgement.code)
            batch.begin([i])
    assert codes == {0: "hard_touchdown", 1: "landed"}


def test_landing_beside_the_area_is_not_landing():
    def aside(observations):
        actions = to_target(observations + np.eye(18, dtype=np.float32)[0] * 4.0)
        actions[:, 2] = -0.15
        return actions

    _, judgement = fly(begun("landing", EnvironmentCfg(action="velocity")), aside, 20.0)
    assert judgement.code in {"outside_area", "off_target"}


def test_what_lies_on_the_area_is_not_the_area():
    mat = thing(30, "crate", (9.0, 8.0, 0.05), (1.4, 1.4, 0.1))
    scene = yard(areas=(ON_LAWN,))
    batches = {
        code: begun("landing", EnvironmentCfg(action="velocity"), scenes=[each])
        for code, each in (
            ("landed", scene),
            ("contact", replace(scene, objects=(*scene.objects, mat))),
        )
    }

    def down(observations):
        actions = np.zeros((1, 4))
        actions[:, :2] = np.clip(0.3 * observations[:, :2], -1.0, 1.0)
        above_m = np.hypot(*observations[0, :2])
        actions[:, 2] = -0.15 if above_m < 0.1 else 0.0
        return actions

    for code, batch in batches.items():
        _, judgement = fly(batch, down, 20.0)
        assert judgement.code == code, judgement.reason
    assert judgement.reason.startswith("touched object 30 (crate) at")


def test_a_scene_without_a_place_for_the_task_is_refused():
    bare = empty_scene()
    low = replace(bare, extent_max_enu_m=(40.0, 40.0, 1.0))
    for task, scene, says in (
        ("landing", bare, "it has no landing area for iris but its start"),
        ("navigation", bare, "it has no area for iris with free air above"),
        ("hover", low, "it has no free air for a target to hover"),
    ):
        with pytest.raises(EnvironmentInputError, match=f"scene 'handmade': {says}"):
            begun(task, scenes=[scene])


def test_a_hexacopter_flies_by_velocities_and_its_motors_cannot_be_commanded_each():
    with pytest.raises(EnvironmentInputError, match="action = 'motors': typhoon has 6 motors"):
        Batch(task_by_name("hover"), ["field"], EnvironmentCfg(vehicle="typhoon", action="motors"))
    batch = begun("hover", EnvironmentCfg(vehicle="typhoon", action="velocity"))
    away_m = batch.observe()[0, :3]
    fly(batch, to_target, 2.0)
    assert np.linalg.norm(batch.observe()[0, :3]) < 0.5 * np.linalg.norm(away_m)
    assert batch.history["rotor_speed_radps"].shape[-1] == 6
