"""One recorded flight of the real stack, read back by the tests of this folder."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pytest
import rerun as rr
from rerun.chunk import RrdReader

from aeroscene.scene import Scene
from aeroscene.solids.shapes import Primitive, scene_primitives
from aeroscene.sources import load_scene
from autonomy.perception import LandingMap
from autonomy.planning import MovingObstacles
from flightsim.autopilot.events import Severity
from flightsim.cameras import RgbdFrame, open_camera_renderer
from flightsim.testbench import Testbench, TestbenchCfg
from flightsim.vehicles.airframe import Airframe
from scenarios.pictures import FlightStory
from scenarios.pictures.tape import FlightTape
from scenarios.recording import Recorder, RunInfo

FLIGHT_S = 3.5
PLAN_ENU_M = ((0.0, 0.0, 1.0), (1.0, 2.0, 3.0), (4.0, 4.0, 4.0))
NEW_PLAN_ENU_M = ((1.0, 2.0, 3.0), (2.0, 2.0, 2.0))
PLAN_S, REPLANNED_US = 2.0, 1_000_000
FIRST_CHOICE_ENU_M, CHOICE_ENU_M = (0.1, 0.0, 0.0), (0.0, 0.1, 0.01)
SEEN = MovingObstacles.balls(
    np.array([[1.0, 2.0, 3.0]]), np.array([[0.5, 0.0, 0.0]]), np.array([0.4])
)
CONTACT = {
    "time_s": 3.1,
    "until_s": 3.4,
    "what": "object 7 (gate)",
    "object_id": 7,
    "position_enu_m": [1.0, 2.0, 3.0],
}
VERDICT = {
    "success": False,
    "code": "contact",
    "reason": "touched object 7",
    "position_rmse_m": 0.25,
    "contacts": [CONTACT],
}
LIMITS = {"slide_m": 0.3}
CONFIG = {"scene": "42", "speed": "max", "camera_hz": 2.0}
FRAME_PERIOD_US = 500_000


def _landing_map() -> LandingMap:
    """A few cells of flat ground, the last unseen, the first unsafe."""
    n = 3
    flat = np.zeros((n, n), dtype=np.float32)
    is_observed, is_safe = np.ones((n, n), dtype=bool), np.ones((n, n), dtype=bool)
    is_observed[2, 2] = is_safe[2, 2] = is_safe[0, 0] = False
    return LandingMap(
        surface_m=flat,
        slope_rad=np.linspace(0.0, 0.2, n * n).reshape(n, n),
        slope_sigma_rad=flat,
        roughness_m=flat + 0.01,
        sigma_m=flat,
        rise_m=flat,
        height_m=flat + np.arange(n, dtype=np.float32),
        is_observed=is_observed,
        is_safe=is_safe,
        clearance_m=np.where(is_safe, 0.4, 0.0),
        enough_clearance_m=0.8,
        axes_enu_m=(np.array([-0.1, 0.0, 0.1]), np.array([-0.1, 0.0, 0.1])),
    )


LANDING = _landing_map()


@dataclass(frozen=True)
class RecordedFlight:
    """A recording and its expected content."""

    path: Path
    scene: Scene
    airframe: Airframe
    primitives: tuple[Primitive, ...]
    history: np.ndarray
    frames: tuple[RgbdFrame, ...]
    story: FlightStory
    """Story of the flight, told without the recording."""


@pytest.fixture(autouse=True)
def strict() -> Iterator[None]:
    """Make rerun raise where it would only warn."""
    before = rr.strict_mode()
    rr.set_strict_mode(True)
    yield
    rr.set_strict_mode(before)


@pytest.fixture(scope="session")
def flight(tmp_path_factory: pytest.TempPathFactory) -> RecordedFlight:
    path = tmp_path_factory.mktemp("recording") / "flight.rrd"
    rows: list[np.ndarray] = []
    frames: list[RgbdFrame] = []
    cfg = TestbenchCfg(seed=5, speed="max", wind=2.0, traffic="drones=1", without="shelter")
    with Testbench(load_scene("42"), cfg, has_network=False) as bench:
        primitives = tuple(scene_primitives(bench.scene))
        recorder = Recorder(
            path,
            scene=bench.scene,
            primitives=primitives,
            airframe=bench.airframe,
            info=RunInfo(scene="42", vehicle="iris", seed=5, config=CONFIG, limits=LIMITS),
        )
        renderer = open_camera_renderer(bench.plant.world, 64, 48)
        plant, autopilot = bench.plant, bench.autopilot
        tape = FlightTape(plant, autopilot, None)
        bench.server.statustext.listeners.append(
            lambda severity, text: recorder.first.log_statustext(plant.time_us, severity, text)
        )
        recorder.first.plans.log(0, np.array(PLAN_ENU_M), PLAN_S)
        recorder.first.log_phase(0, "arm")
        while plant.time_us < FLIGHT_S * 1e6:
            if plant.time_us == REPLANNED_US:
                recorder.first.plans.log(plant.time_us, np.array(NEW_PLAN_ENU_M), PLAN_S)
                recorder.first.states.tracks.log(plant.time_us, SEEN)
            if plant.time_us == 2_000_000:
                assert autopilot.arm(is_forced=True).is_accepted
            bench.simulator.step()
            rows.append(plant.history.copy())
            recorder.on_tick(plant, autopilot)
            tape.on_tick()
            if plant.time_us % FRAME_PERIOD_US == 0:
                for mount in bench.airframe.rgbd_cameras:
                    frames.append(renderer.render(plant.data, mount.name, plant.time_us))
                    recorder.first.log_frame(frames[-1])
        recorder.first.log_statustext(plant.time_us, Severity.WARNING, "battery low")
        recorder.first.log_phase(plant.time_us, "search")
        recorder.first.states.landing.log(plant.time_us - 200_000, LANDING, FIRST_CHOICE_ENU_M)
        recorder.first.states.landing.log(plant.time_us, LANDING, CHOICE_ENU_M)
        renderer.close()
        recorder.conclude(VERDICT)
        return RecordedFlight(
            path=path,
            scene=bench.scene,
            airframe=bench.airframe,
            primitives=primitives,
            history=np.concatenate(rows),
            frames=tuple(frames),
            story=tape.story(VERDICT["reason"]),
        )


class Contents:
    """A recording in memory, by entity and component, read by rerun's own reader."""

    def __init__(self, path: Path) -> None:
        self.reader = RrdReader(path)
        self.chunks = list(self.reader.stream())

    def entities(self) -> set[str]:
        return {chunk.entity_path for chunk in self.chunks}

    def column(self, entity: str, component: str) -> tuple[np.ndarray, list[Any]]:
        """Times in microseconds (empty where static) and values, in order of time."""
        times: list[int] = []
        values: list[Any] = []
        for chunk in self.chunks:
            batch = chunk.to_record_batch()
            if chunk.entity_path != f"/{entity}" or component not in batch.schema.names:
                continue
            values += batch.column(component).to_pylist()
            if not chunk.is_static:
                times += batch.column("sim_time").cast(pa.int64()).to_pylist()
        if not times:
            return np.array([]), values
        order = np.argsort(times, kind="stable")
        return np.array(times)[order] // 1000, [values[i] for i in order]


@pytest.fixture(scope="session")
def contents(flight: RecordedFlight) -> Contents:
    return Contents(flight.path)
