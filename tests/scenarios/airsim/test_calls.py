"""What clients of AirSim's API are answered, and how the vehicles fly that they command."""

import json
import math
import socket
import subprocess
import sys

import cv2
import numpy as np
import pytest

from flightsim.frames import swap_enu_ned
from flightsim.testbench import TestbenchCfg
from scenarios.airsim.pictures import segment_rgb
from scenarios.run.cfg import SitlCfg
from scenarios.run.sitl import Sitl
from tests.instances import free_port, own_instance
from tests.scenarios.airsim.caller import Caller, CallError, pose, vector

SETTINGS = {
    "SettingsVersion": 1.2,
    "SimMode": "Multirotor",
    "Wind": {"X": 0.0, "Y": 1.0, "Z": 0.0},
    "SubWindows": [],
    "CameraDefaults": {"CaptureSettings": [{"ImageType": 0, "Width": 32, "Height": 24}]},
    "Vehicles": {
        "Drone1": {
            "VehicleType": "SimpleFlight",
            "Cameras": {
                "down": {
                    "CaptureSettings": [
                        {"ImageType": kind, "Width": 33, "Height": 25, "FOV_Degrees": 60}
                        for kind in (0, 1, 2, 5)
                    ],
                    "Pitch": -90,
                    "Z": 0.1,
                }
            },
            "Sensors": {
                "Below": {"SensorType": 5, "Pitch": -90, "MinDistance": 0, "MaxDistance": 50},
                "Lidar": {
                    "SensorType": 6,
                    "NumberOfChannels": 4,
                    "PointsPerSecond": 1440,
                    "VerticalFOVUpper": -30,
                    "VerticalFOVLower": -60,
                },
            },
        },
        "Drone2": {"VehicleType": "PX4Multirotor", "X": 4, "Y": 3, "Yaw": 90, "AutoCreate": False},
    },
}
FORWARD_ONLY, STILL = 1, {"is_rate": False, "yaw_or_rate": 0.0}
PNG, NUMBERS = (False, True), (True, False)


@pytest.fixture(scope="module")
def caller(tmp_path_factory):
    path = tmp_path_factory.mktemp("airsim") / "settings.json"
    path.write_text(json.dumps(SETTINGS))
    bench = TestbenchCfg(speed="max", instance=own_instance(), seed=3, aiding="mocap")
    port = free_port(socket.SOCK_STREAM)
    cfg = SitlCfg(scene="field", bench=bench, airsim_settings=path, airsim_port=port)
    with Sitl(cfg, has_network=False) as sitl:
        caller = Caller(sitl, port)
        for _ in range(150):
            caller.tick()
        yield caller
        caller.close()


@pytest.fixture
def flying(caller):
    """The first vehicle in the air, three metres above its start."""
    caller.call("reset")
    caller.call("enableApiControl", True, "")
    assert caller.call("armDisarm", True, "") is True
    assert caller.call("takeoff", 20, "") is True
    return caller


def truth(caller, number=0):
    return caller.sitl.bench.vehicles[number].plant.truth


def place_ned(caller, number=0):
    """True place from the start, north, east and down."""
    vehicle = caller.sitl.bench.vehicles[number]
    world = vehicle.plant.world
    start = world.rest_qpos[world.qpos_address : world.qpos_address + 3]
    return swap_enu_ned(tuple(np.array(vehicle.plant.truth.position_enu_m) - start))


def position(answer):
    return tuple(answer[f"{axis}_val"] for axis in "xyz")


def image(caller, kind, form, camera="down"):
    request = {"camera_name": camera, "image_type": kind, "annotation_name": ""}
    request |= dict(zip(("pixels_as_float", "compress"), form, strict=True))
    (answer,) = caller.call("simGetImages", [request], "")
    return answer


def test_vehicles_stand_where_the_settings_say(caller):
    caller.call("reset")
    assert caller.call("listVehicles") == ["Drone1"]
    assert caller.call("simAddVehicle", "Drone2", "simpleflight", pose(0, 0, 0), "") is True
    assert caller.call("listVehicles") == ["Drone1", "Drone2"]
    first, second = truth(caller), truth(caller, 1)
    apart = np.array(second.position_enu_m) - np.array(first.position_enu_m)
    assert apart == pytest.approx([3, 4, 0], abs=0.1)
    heading = position(caller.call("simGetVehiclePose", "Drone2")["position"])
    assert heading == pytest.approx((0, 0, 0), abs=0.05)
    w, _, _, z = second.quat_wxyz
    assert 2 * math.atan2(z, w) == pytest.approx(0.0, abs=0.05)  # Yaw 90 is the east.
    with pytest.raises(CallError, match="'Drone3' is unknown; valid: Drone1, Drone2"):
        caller.call("getMultirotorState", "Drone3")
    assert json.loads(caller.call("getSettingsString")) == SETTINGS


def test_what_is_not_offered_or_wrong_is_named(caller):
    caller.call("reset")
    caller.call("enableApiControl", False, "")
    for method, args, line in (
        ("simLoadLevel", ("x",), "simLoadLevel is not offered: there is no Unreal Engine"),
        ("fly", (), "'fly' is no method"),
        ("takeoff", (1, "", 3), "takeoff has 3 arguments; valid: 0 to 2"),
        ("takeoff", ("soon", ""), "takeoff: timeout_sec is not valid"),
        ("moveToPosition", (0, 0, float("nan"), 1), "position is not finite"),
        ("hover", ("",), "API control is off"),
        ("getLidarData", ("Other", ""), "lidar 'Other' is unknown; valid: Lidar"),
        ("simSetVehiclePose", (pose(0, 0, 1), True, ""), "is inside of a solid"),
        ("simGetImage", ("nose", 0, ""), "camera 'nose' is unknown"),
        ("simSetWeatherParameter", (0, 0.5), "weather Rain is not offered; valid: Dust .*, Fog"),
    ):
        with pytest.raises(CallError, match=line):
            caller.call(method, *args)


def test_sensors_at_rest_measure_what_is_so(caller):
    caller.call("reset")
    state = caller.call("getMultirotorState", "")
    assert state["landed_state"] == 0
    assert state["ready"] is True
    assert position(state["kinematics_estimated"]["position"]) == pytest.approx((0, 0, 0), abs=0.2)
    home, fix = caller.call("getHomeGeoPoint", ""), caller.call("getGpsData", "", "")
    assert fix["gnss"]["geo_point"]["latitude"] == pytest.approx(home["latitude"], abs=2e-5)
    specific = position(caller.call("getImuData", "", "")["linear_acceleration"])
    assert specific == pytest.approx((0, 0, -9.81), abs=0.4)
    field = position(caller.call("getMagnetometerData", "", "")["magnetic_field_body"])
    assert 0.2 < math.hypot(*field) < 0.7  # The earth's, in gauss.
    pressure = caller.call("getBarometerData", "", "")["pressure"]
    around = caller.call("simGetGroundTruthEnvironment", "")["air_pressure"]
    assert pressure == pytest.approx(around, abs=60)
    wind = caller.sitl.bench.plant.wind
    assert (wind.speed_mps, wind.from_deg) == pytest.approx((1.0, 270.0))


def test_moves_lead_where_they_say_in_north_east_down(flying):
    assert place_ned(flying) == pytest.approx((0, 0, -3), abs=0.4)
    assert flying.call("getMultirotorState", "")["landed_state"] == 1
    assert flying.call("moveToPosition", 6, 3, -5, 4, 60, 0, STILL, -1, 1, "") is True
    assert place_ned(flying) == pytest.approx((6, 3, -5), abs=0.6)
    told = position(flying.call("simGetGroundTruthKinematics", "")["position"])
    assert told == pytest.approx(place_ned(flying), abs=0.1)
    assert flying.call("rotateToYaw", 90.0, 20, 2.0, "") is True
    w, _, _, z = truth(flying).quat_wxyz
    assert 2 * math.atan2(z, w) == pytest.approx(0.0, abs=0.1)
    assert flying.call("moveByVelocityBodyFrame", 2, 0, 0, 3, 0, STILL, "") is True
    north, east, _ = place_ned(flying)
    assert east > 6.0
    assert north == pytest.approx(6.0, abs=0.8)
    points = [vector(6, 0, -4), vector(0, 0, -4)]
    assert flying.call("moveOnPath", points, 3, 60, FORWARD_ONLY, STILL, -1, 1, "") is True
    assert place_ned(flying) == pytest.approx((0, 0, -4), abs=0.6)
    assert flying.call("land", 60, "") is True
    assert flying.call("armDisarm", False, "") is True
    assert place_ned(flying) == pytest.approx((0, 0, 0), abs=0.6)


def test_a_new_move_ends_the_one_before_with_false(flying):
    first = flying.send("moveToPosition", 50, 0, -3, 2, 60, 0, STILL, -1, 1, "")
    assert flying.sitl.bench.simulator.interlude is not None
    flying.tick()
    other = Caller(flying.sitl, flying.sitl.bench.simulator.interlude.port)
    assert other.call("hover", "") is True
    other.close()
    assert flying.wait(first) is False


def test_attitudes_and_sticks_are_flown(flying):
    # Clients turn the sign of pitch over before they send it: nose down is negative on the wire.
    assert flying.call("moveByRollPitchYawZ", 0.0, -0.15, 0.0, -3.0, 2.0, "") is True
    north, east, down = place_ned(flying)
    assert north > 1.0
    assert abs(east) < 1.0
    assert down == pytest.approx(-3, abs=0.7)
    move = flying.send("moveByManual", 3, 3, -100, 2.0, 0, STILL, "")
    other = Caller(flying.sitl, flying.sitl.bench.simulator.interlude.port)
    sticks = {"roll": 0.0, "pitch": 0.0, "throttle": 1.0, "yaw": 0.0, "is_valid": True}
    other.call("moveByRC", sticks, "")
    other.close()
    assert flying.wait(move) is True
    assert place_ned(flying)[2] < down - 1.5


def test_images_and_ranges_agree_with_the_height(flying):
    height_m = -place_ned(flying)[2] + flying.sitl.bench.airframe.leg_length_m
    depth = image(flying, 1, NUMBERS)
    planar = np.array(depth["image_data_float"]).reshape(depth["height"], depth["width"])
    assert planar.shape == (25, 33)
    assert planar[12, 16] == pytest.approx(height_m - 0.1, abs=0.15)
    along = np.array(image(flying, 2, NUMBERS)["image_data_float"]).reshape(25, 33)
    assert along[0, 0] > planar[0, 0] * 1.1
    scene = cv2.imdecode(np.frombuffer(image(flying, 0, PNG)["image_data_uint8"], "u1"), 1)
    assert scene.shape == (25, 33, 3)
    assert scene.std() > 0
    assert image(flying, 0, PNG, "0")["width"] == 32
    raw = image(flying, 5, (False, False))
    assert len(raw["image_data_uint8"]) == 3 * 33 * 25
    assert flying.call("simSetSegmentationObjectID", ".*", 20, True) is True
    pixels = image(flying, 5, (False, False))["image_data_uint8"]
    blue_green_red = bytes(reversed(segment_rgb(20)))
    assert pixels == blue_green_red * (33 * 25) != raw["image_data_uint8"]
    measured = flying.call("getDistanceSensorData", "Below", "")
    assert measured["distance"] == pytest.approx(height_m, abs=0.1)
    cloud = flying.call("getLidarData", "", "")
    points = np.array(cloud["point_cloud"]).reshape(-1, 3)
    assert len(points) == 144
    # In the local frame both the pad of the start and the flat field lie just below its legs.
    below_legs_m = points[:, 2] - flying.sitl.bench.airframe.leg_length_m
    assert below_legs_m.min() > -0.05
    assert below_legs_m.max() < 0.12


def test_time_stands_still_and_goes_on_for_as_long_as_is_asked(caller):
    plant = caller.sitl.bench.plant
    caller.call("simPause", True)
    before_us = plant.time_us
    assert caller.call("simIsPaused") is True
    assert plant.time_us == before_us
    caller.call("simContinueForTime", 0.5)
    assert plant.time_us == before_us + 500_000
    assert caller.call("simIsPaused") is True
    caller.call("simPause", False)
    assert caller.call("simIsPaused") is False


def test_a_jump_takes_the_estimate_along_and_reset_leads_back(flying):
    turned = pose(20.0, -10.0, -8.0)
    turned["orientation"] = {"w_val": 0.6, "x_val": 0.0, "y_val": 0.0, "z_val": 0.8}
    flying.call("simSetVehiclePose", turned, True, "")
    assert place_ned(flying) == pytest.approx((20, -10, -8), abs=0.1)
    for _ in range(150):
        flying.tick()
    assert place_ned(flying) == pytest.approx((20, -10, -8), abs=1.0)
    plant = flying.sitl.bench.plant
    believed, true = plant.estimate.position_enu_m, plant.truth.position_enu_m
    assert math.dist(believed, true) < 0.3
    w, _, _, z = plant.truth.quat_wxyz
    assert 2 * math.atan2(z, w) == pytest.approx(math.pi / 2 - 2 * math.atan2(0.8, 0.6), abs=0.1)
    assert np.abs(np.dot(plant.estimate.quat_wxyz, plant.truth.quat_wxyz)) > 0.999
    flying.call("reset")
    assert place_ned(flying) == pytest.approx((0, 0, 0), abs=0.05)
    state = flying.call("getMultirotorState", "")
    assert state["landed_state"] == 0
    assert flying.call("isApiControlEnabled", "") is False
    assert flying.sitl.bench.autopilot.is_armed is False


def test_the_published_client_flies(caller):
    pytest.importorskip("cosysairsim")
    port = caller.sitl.bench.simulator.interlude.port
    command = [sys.executable, "-m", "tests.scenarios.airsim.published", str(port)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        while process.poll() is None:
            caller.tick()
        assert process.returncode == 0
        reached = json.loads(process.stdout.read())
    assert reached["top"] == pytest.approx([2, 1, -4], abs=0.6)
    assert reached["end"] == pytest.approx([0, 0, 0], abs=0.5)
    assert reached["refused"] == "simListAssets is not offered: there is no Unreal Engine"
    assert reached["depth"] == [144, 256]


def test_weather_hides_what_is_far(caller):
    caller.call("reset")
    sky, ground = slice(0, 3), slice(-3, None)
    clear = image(caller, 0, (False, False), "0")["image_data_uint8"]
    caller.call("simEnableWeather", True)
    caller.call("simSetWeatherParameter", 7, 1.0)
    foggy = image(caller, 0, (False, False), "0")["image_data_uint8"]
    caller.call("simSetWeatherParameter", 7, 0.0)
    fog = bytes((214, 209, 204))  # Blue, green, red.
    assert foggy[sky] == fog != clear[sky]
    assert np.ptp(np.array([list(foggy[ground]), list(clear[ground])], float), axis=0).max() < 25
