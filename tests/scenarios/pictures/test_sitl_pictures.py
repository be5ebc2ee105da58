import pytest

from flightsim.testbench import TestbenchCfg, TestbenchError
from scenarios.pictures.recorded_story import read_story
from scenarios.pictures.tape import FlightTape
from scenarios.run.cfg import SitlCfg
from scenarios.run.sitl import Sitl
from tests.instances import own_instance

BENCH = TestbenchCfg(speed="max", instance=own_instance())


def test_run_that_nobody_flies_leaves_a_picture(tmp_path):
    cfg = SitlCfg(bench=BENCH, headless_seconds=0.5, pictures=tmp_path / "out")
    with Sitl(cfg) as sitl:
        sitl.run()
    assert sitl.pictures == [tmp_path / "out" / "flight.png"]
    assert sitl.pictures[0].stat().st_size > 0


def test_a_run_draws_lines_where_that_is_asked_for(tmp_path):
    cfg = SitlCfg(bench=BENCH, headless_seconds=0.5, pictures=tmp_path, formats=("svg",))
    with Sitl(cfg) as sitl:
        sitl.run()
    assert sitl.pictures == [tmp_path / "flight.svg"]
    assert (tmp_path / "flight.svg").read_bytes().count(b"<path") > 50
    assert {file.suffix for file in tmp_path.iterdir()} == {".svg"}


def test_folder_that_vanished_under_a_file_costs_no_verdict(tmp_path, caplog):
    cfg = SitlCfg(bench=BENCH, headless_seconds=0.1, pictures=tmp_path / "out")
    with Sitl(cfg) as sitl:
        (tmp_path / "out").touch()
        assert sitl.run().reason == "ended"
    assert sitl.pictures == []
    assert "cannot be written" in caplog.text


def test_file_in_place_of_the_folder_is_refused_before_anything_starts(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(TestbenchError, match="is a file; valid: a folder"):
        SitlCfg(bench=BENCH, pictures=tmp_path / "file")


def test_phases_of_a_flight_that_just_ended_are_those_of_its_recording(tmp_path):
    record = tmp_path / "flight.rrd"
    cfg = SitlCfg(demo=True, bench=BENCH, headless_seconds=2.0, record=record, camera_hz=0.0)
    with Sitl(cfg, has_network=False) as sitl:
        tape = FlightTape(sitl.bench.plant, sitl.bench.autopilot, sitl.pilot)
        sitl.bench.observers.append(tape.on_tick)
        sitl.run()
    told = tape.story("ended").phases
    assert told == read_story(record).phases
    assert [name for _, name in told[:2]] == ["connect", "wait for health"]
