"""What a settings.json may say, and what it is told."""

import json

import pytest

from flightsim.testbench import TestbenchError
from scenarios.airsim.settings import read_settings


def read(tmp_path, plain):
    path = tmp_path / "settings.json"
    path.write_text(plain if isinstance(plain, str) else json.dumps(plain))
    return read_settings(path)


def vehicle(**fields):
    return {"Vehicles": {"A": {"VehicleType": "SimpleFlight", **fields}}}


@pytest.mark.parametrize(
    ("plain", "line"),
    [
        ("{", "is no JSON"),
        ("[" * 100_000, "is no JSON"),
        ("3", "is 3; valid: an object of JSON"),
        ({"SimMode": "Car"}, "SimMode is 'Car'; valid: Multirotor"),
        ({"ClockSpeed": -1}, "ClockSpeed is -1; valid: 0.001 to 100"),
        ({"LocalHostIp": "0.0.0.0"}, "LocalHostIp is '0.0.0.0'; valid: 127.0.0.1"),
        ({"Vehicles": {"A": {"VehicleType": "PhysXCar"}}}, "VehicleType is 'PhysXCar'; valid: Sim"),
        (vehicle(X="far"), "Vehicles.A.X is 'far'; valid: -10000 to 10000 m"),
        (
            vehicle(Sensors={"S": {"SensorType": 2, "Enabled": False}}),
            "Vehicles.A.Sensors.S.Enabled is false; valid: true",
        ),
        (
            vehicle(Cameras={"c": {"CaptureSettings": [{"Width": 9999}]}}),
            r"CaptureSettings\[1\].Width is 9999; valid: a whole number from 1 to 4320",
        ),
    ],
)
def test_a_bad_one_is_refused_in_one_line(tmp_path, plain, line):
    with pytest.raises(TestbenchError, match=line) as caught:
        read(tmp_path, plain)
    assert "\n" not in str(caught.value)


def test_what_is_not_honoured_is_listed(tmp_path):
    settings = read(tmp_path, {"ViewMode": "Fpv"} | vehicle(PawnPath="x", X=1))
    assert settings.ignored == ("ViewMode", "Vehicles.A.PawnPath")
    assert settings.vehicles[0].offset_ned_m == (1.0, 0.0, 0.0)


def test_sensors_of_all_vehicles_and_a_lidar_that_looks_sideways(tmp_path):
    lidar = {
        "SensorType": 6,
        "NumberOfChannels": 1,
        "PointsPerSecond": 3600,
        "HorizontalFOVStart": -20,
        "HorizontalFOVEnd": 20,
        "VerticalFOVUpper": 0,
    }
    settings = read(tmp_path, {"DefaultSensors": {"L": lidar}} | vehicle())
    directions = settings.vehicles[0].lidars["L"].directions
    assert len(directions) == 41
    assert directions[:, 0].min() > 0.93
    assert directions[:, 2] == pytest.approx(0.0)
