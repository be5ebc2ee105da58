"""`aeroscene-sitl --vehicles`: one world, a verdict for each, one recording."""

import json
import math

import pytest
from rerun.chunk import RrdReader

from flightsim.testbench import TestbenchCfg
from scenarios.cli.sitl import main
from scenarios.run.cfg import SitlCfg
from scenarios.run.missions import plan_missions
from scenarios.run.sitl import Sitl
from tests.instances import own_instance

BRIEF = ("--scene", "field", "--speed", "max", "--headless-seconds", "2", "--json")


def run(capsys, *args):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("signal.signal", lambda *_: None)  # pytest's own handlers stay
        status = main([*BRIEF, "--instance", str(own_instance()), *args])
    return status, capsys.readouterr()


def test_every_vehicle_is_in_the_result_and_in_the_recording(capsys, tmp_path):
    path = tmp_path / "two.rrd"
    status, told = run(
        capsys, "--vehicles", "iris,hummingbird", "--record", str(path), "--camera-hz", "0"
    )
    result = json.loads(told.out)
    assert status == 0
    first, second = result["vehicles"]
    assert (first["vehicle"], second["vehicle"]) == ("iris", "hummingbird")
    assert second["system"] == first["system"] + 1
    assert first["state_hash"] != second["state_hash"]
    assert math.dist(first["start"], second["start"]) >= 3.0
    assert len(json.loads(path.with_suffix(".json").read_text())["mates"]) == 1
    entities = {chunk.entity_path.strip("/") for chunk in RrdReader(path).stream()}
    for entity in (
        "world/vehicle/fuselage",
        "world/vehicle_2/vehicle/fuselage",
        "world/vehicle_2/trajectory/executed",
        "vehicle_2/state/position/up",
        "vehicle_2/motors/speed",
    ):
        assert entity in entities


def test_the_same_seed_gives_the_same_flights(capsys):
    hashes = [json.loads(run(capsys, "--vehicles", "2")[1].out)["state_hash"] for _ in range(2)]
    assert hashes[0] == hashes[1]


def test_the_one_vehicle_that_is_named_flies(capsys):
    told = json.loads(run(capsys, "--vehicles", "hummingbird")[1].out)
    assert told["vehicle"] == "hummingbird"


def test_every_vehicle_has_the_cameras_that_were_asked_for():
    cfg = SitlCfg(scene="field", vehicles="2", bench=TestbenchCfg(camera=("left,yaw=90",)))
    with Sitl(cfg, has_network=False) as sitl:
        for flight in sitl.flights:
            assert "left" in [mount.name for mount in flight.vehicle.airframe.cameras]


def test_pilots_of_one_world_fly_to_areas_apart():
    cfg = SitlCfg(scene="42", vehicles="2")
    with Sitl(cfg, has_network=False) as sitl:
        missions = plan_missions(cfg, sitl.bench.vehicles, None)
        starts = [vehicle.scene.start_position_enu_m for vehicle in sitl.bench.vehicles]
    areas = [mission.area.centroid for mission in missions]
    for i, area in enumerate(areas):
        others = areas[:i] + areas[i + 1 :] + starts[:i] + starts[i + 1 :]
        assert min(math.dist(area, other) for other in others) >= 4.0
    assigned = {mission.area.id for mission in missions}
    assert all(
        not assigned & {each.id for each in mission.alternates} - {mission.area.id}
        for mission in missions
    )


@pytest.mark.parametrize(
    ("vehicles", "says"),
    [
        ("0", "vehicles '0' is not valid; valid: 1 to 100"),
        ("-3", "vehicles '-3' is not valid"),
        ("iris,", "vehicles 'iris,' is not valid"),
        ("iris,zeppelin", "zeppelin"),
    ],
)
def test_bad_numbers_and_names_are_refused_in_a_line(capsys, tmp_path, vehicles, says):
    path = tmp_path / "never.rrd"
    with pytest.raises(SystemExit) as ending:
        run(capsys, f"--vehicles={vehicles}", "--record", str(path))
    assert ending.value.code == 2
    assert says in capsys.readouterr().err
    assert not path.exists()


def test_more_vehicles_than_the_start_has_room_for_open_nothing(capsys, tmp_path):
    path = tmp_path / "never.rrd"
    # A circle of 15 m has no room for so many, 3 m apart, whatever stands in it.
    with pytest.raises(SystemExit) as ending:
        main(["--scene", "42", "--vehicles", "90", "--record", str(path)])
    assert ending.value.code == 2
    (line,) = [each for each in capsys.readouterr().err.splitlines() if "error" in each]
    assert "vehicles 90: the start of scene 'aeroscene-0042' has room for" in line
    assert not path.exists()
