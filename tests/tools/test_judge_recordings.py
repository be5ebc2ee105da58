"""The second judge confirms a real flight, and objects to each fault that is put in by hand."""

import copy
import dataclasses

import judge_recordings
import numpy as np
import pytest
from judging.judge import judge_recording
from judging.recording import read_recording
from judging.solids import Solid, solids_of
from scipy.spatial.transform import Rotation

from flightsim.testbench import TestbenchCfg
from scenarios.baselines.straight_line import StraightLinePilot
from scenarios.run.cfg import SitlCfg
from scenarios.run.sitl import Sitl
from tests.scenarios.landing_scenes import ON_CONTAINER, ON_LAWN, rectangle, yard


@pytest.fixture(scope="module")
def landed(tmp_path_factory):
    """A recording of a flight in a straight line over crates onto a container."""
    path = tmp_path_factory.mktemp("judged") / "flight.rrd"
    bench = TestbenchCfg(speed="max")
    cfg = SitlCfg(bench=bench, record=path, camera_hz=0.0, area=ON_CONTAINER.id)
    with Sitl(cfg, scene=yard(), pilot=StraightLinePilot, has_network=False) as sitl:
        assert sitl.run().success
    return path


@pytest.fixture(scope="module")
def told(landed):
    """The flight as it is read."""
    return read_recording(landed)


@pytest.fixture
def flight(told):
    """A copy to put a fault into."""
    return copy.deepcopy(told)


def test_a_real_flight_is_confirmed(landed, told, capsys):
    assert judge_recording(told).success
    assert judge_recordings.main(judge_recordings.JudgeCfg(paths=(landed.parent,))) == 0
    assert "1 verdicts: 1 confirmed" in capsys.readouterr().out


def test_a_verdict_that_is_too_kind_is_contradicted(landed, monkeypatch, capsys):
    def moved(path):
        flight = read_recording(path)
        flight.position_enu_m = flight.position_enu_m + [0.0, 3.0, 0.0]
        return flight

    monkeypatch.setattr(judge_recordings, "read_recording", moved)
    assert judge_recordings.main(judge_recordings.JudgeCfg(paths=(landed,))) == 1
    assert "1 false successes, 0 false failures" in capsys.readouterr().out


def in_the_way(flight):
    half_m = np.array([0.3, 0.3, 0.3])
    middle_m = np.median(flight.position_enu_m, axis=0)
    crate = Solid("crate", "box", middle_m, Rotation.identity(), half_m, np.empty((0, 4)))
    flight.solids.append(crate)


def tipped(flight):
    last = len(flight.time_s) - 1
    quats = flight.attitude.as_quat()
    quats[last] = (Rotation.from_euler("x", 30, degrees=True) * flight.attitude[last]).as_quat()
    flight.attitude = Rotation.from_quat(quats)


def sliding(flight):
    flight.position_enu_m[-125:, 0] += np.linspace(0.0, 0.45, 125)


def turning(flight):
    flight.rotor_speed_radps[-1] = 200.0


def spun_up(flight):
    flight.rotor_speed_radps[-100:-50] = flight.rotor_speed_radps.max()


def elsewhere(flight):
    flight.verdict["area"] = ON_LAWN.id


def off_the_point(flight):
    flight.chosen_enu_m = np.array(ON_CONTAINER.centroid) + [1.2, 0.0, 0.0]


@pytest.mark.parametrize(
    ("fault", "objection"),
    [
        (in_the_way, "touched nothing before touchdown"),
        (tipped, "upright"),
        (sliding, "at rest"),
        (sliding, "did not slide"),
        (turning, "rotors stand still"),
        (spun_up, "rotors did not take the weight again"),
        (elsewhere, "all soles inside"),
        (off_the_point, "near the chosen point"),
    ],
)
def test_each_fault_has_its_objection(flight, fault, objection):
    fault(flight)
    opinion = judge_recording(flight)
    assert objection in opinion.objections
    assert opinion.success is False


def test_an_area_with_one_sole_beside_it_is_missed(flight):
    x, y = flight.position_enu_m[-1, :2]
    narrow = rectangle(ON_CONTAINER.id, (x + 0.3, y, ON_CONTAINER.centroid[2]), (0.3, 0.6), 1)
    flight.scene["interaction_areas"] = [dataclasses.asdict(narrow)]
    assert "all soles inside" in judge_recording(flight).objections


def test_distances_are_those_of_the_shapes_that_are_drawn():
    quarter_turn = [0.0, 0.0, np.sin(np.pi / 4), np.cos(np.pi / 4)]
    placed = {"centers": [[1.0, 0.0, 0.0]], "quaternions": [quarter_turn]}
    point = np.array([[1.0, 3.0, 0.0]])

    def distance(name, **sizes):
        columns = {f"{name}:{key}": value for key, value in (placed | sizes).items()}
        (solid,) = solids_of("thing", columns)
        return solid.distances(point)[0]

    # Turned by 90 degrees, the first axis of each shape points to the point.
    assert distance("Boxes3D", half_sizes=[[2.0, 1.0, 1.0]]) == pytest.approx(1.0)
    assert distance("Cylinders3D", radii=[0.5], lengths=[2.0]) == pytest.approx(2.5)
    assert distance("Ellipsoids3D", half_sizes=[[3.0, 1.0, 1.0]]) == pytest.approx(0.0, abs=1e-9)


def test_hulls_of_a_mesh_are_told_apart_where_they_share_a_face():
    unit = np.array(np.meshgrid([0, 1], [0, 1], [0, 1], indexing="ij")).reshape(3, -1).T
    faces = [(0, 2, 1), (1, 2, 3), (4, 5, 6), (5, 7, 6), (0, 1, 4), (1, 5, 4)]
    faces += [(2, 6, 3), (3, 6, 7), (0, 4, 2), (2, 4, 6), (1, 3, 5), (3, 7, 5)]
    hull = [unit[i] for face in faces for i in face]
    beside = [corner + [1, 0, 0] for corner in hull]
    hulls = list(solids_of("thing", {"Mesh3D:vertex_positions": [*hull, *beside]}))
    assert len(hulls) == 2
    inside_second = np.array([[1.5, 0.5, 0.5]])
    assert [hull.distances(inside_second)[0] for hull in hulls] == pytest.approx([0.5, -0.5])
