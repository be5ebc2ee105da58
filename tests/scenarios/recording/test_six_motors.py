"""A recording of a vehicle that is neither a quadrotor nor one that ships under its name."""

from dataclasses import replace

import numpy as np
import pytest

from autonomy.types import IDLE
from flightsim.plant import Plant, PlantCfg
from flightsim.vehicles.catalogue import AIRFRAMES
from flightsim.world import build_world
from scenarios.pictures.recorded_story import read_airframe
from scenarios.recording.metadata import RunInfo
from scenarios.recording.recorder import Recorder
from scenarios.recording.rows import RecordedRows
from scenarios.recording.summary import readable
from scenarios.trial_data.reading import read_trial
from scenarios.trial_data.ulog import write_ulog
from tests.flightsim.handmade import empty_scene

MINE = replace(AIRFRAMES["typhoon"], name="mine", handle="drones/mine.toml")
PARTS = ("1", "2", "3", "4", "5", "6")


@pytest.fixture(scope="module")
def flight(tmp_path_factory):
    path = tmp_path_factory.mktemp("recording") / "mine.rrd"
    world = build_world(empty_scene(), MINE)
    plant = Plant(world, PlantCfg(seed=1))
    plant.align()
    plant.apply(IDLE)
    rows = []
    info = RunInfo(scene=world.scene.scene_id, vehicle="mine", seed=1)
    with Recorder(
        path, scene=world.scene, primitives=world.solids, airframe=MINE, info=info
    ) as recorder:
        for _ in range(30):
            plant.advance()
            rows.append(plant.history.copy())
            recorder.on_tick(plant)
    return path, np.concatenate(rows)


def test_it_holds_every_motor(flight, tmp_path):
    path, history = flight
    trial = read_trial(path)
    assert trial.rotors == PARTS
    assert history["rotor_speed_radps"].shape == (150, 6)
    for prefix in ("command", "speed"):
        read = trial.array("motors", prefix, "radps", PARTS)
        np.testing.assert_array_equal(read, history[f"rotor_{prefix}_radps"])
    assert write_ulog(trial, tmp_path / "mine.ulg").stat().st_size > 10_000


def test_it_holds_the_vehicle(flight):
    path, _ = flight
    with readable(path) as source:
        assert read_airframe(RecordedRows(source, ()), path) == MINE
