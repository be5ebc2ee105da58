"""AirSim's settings.json: vehicles with their places, cameras and sensors, the clock, the wind.

Fields that mean something here are checked. All others are kept as a list of paths, so that a run
can name what it does not honour.

Source: github.com/microsoft/AirSim, docs/settings.md, sensors.md and lidar.md.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import msgspec

from aeroscene.files import UnpackError, read_bounded
from aeroscene.files.toml_fields import Fields
from aeroscene.files.visible import is_visible, shown
from aeroscene.scene import Scene
from autonomy.types import Vector3
from flightsim.testbench import TestbenchError
from scenarios.airsim.cameras import MOST_PX, Camera, Lens, quat_frd
from scenarios.airsim.messages import Pose, Vector3r
from scenarios.airsim.rangers import FRAMES, DistanceCfg, LidarCfg

PORT = 41451
"""Port of AirSim's clients."""
_MOST_BYTES = 1 << 20
_MOST_ENTRIES, _MOST_NAME = 100, 60
_TYPES = ("simpleflight", "px4multirotor", "arducopter", "arducoptersolo")
_DISTANCE, _LIDAR = 5, 6
"""AirSim's SensorType; 1 to 4 are barometer, IMU, GPS and magnetometer."""
_FAR_M, _TURN_DEG = 1e4, 360.0


@dataclass(frozen=True, kw_only=True, eq=False)
class VehicleSettings:
    """A vehicle of the settings."""

    name: str
    offset_ned_m: Vector3 | None = None
    """Place of its start from the scene's own start; None without X, Y and Z."""
    yaw_deg: float | None = None
    """Heading, clockwise from north; None is the heading of the scene's start."""
    is_created: bool = True
    """False if it exists for clients only once one has added it by simAddVehicle."""
    cameras: Mapping[str, Camera] = field(default_factory=dict)
    lidars: Mapping[str, LidarCfg] = field(default_factory=dict)
    distances: Mapping[str, DistanceCfg] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True, eq=False)
class AirsimSettings:
    """Settings of a run that a settings.json asks for."""

    vehicles: tuple[VehicleSettings, ...] = ()
    lens: Lens = field(default_factory=Lens)
    """Lens of the cameras that the settings do not name."""
    lenses: Mapping[int, Lens] = field(default_factory=dict)
    """The same by image type."""
    clock_speed: float = 1.0
    """Simulated seconds in a second of the wall clock."""
    port: int = PORT
    wind: Vector3r | None = None
    """Wind, m/s north, east and down; None is the wind of the run."""
    origin: tuple[float, float, float] | None = None
    """Latitude and longitude in degrees and altitude in metres of the scene's origin."""
    text: str = "{}"
    """The file, for clients that ask for it."""
    ignored: tuple[str, ...] = ()
    """Paths of fields that change nothing here."""

    def located(self, scene: Scene) -> Scene:
        """A scene at the place on the earth that the settings name."""
        if self.origin is None:
            return scene
        latitude_deg, longitude_deg, altitude_m = self.origin
        return replace(
            scene, latitude_deg=latitude_deg, longitude_deg=longitude_deg, altitude_m=altitude_m
        )


def read_settings(path: Path) -> AirsimSettings:
    """Read a settings.json.

    Raises:
        TestbenchError: If it is none, or asks for what cannot be had; the line names file, field
            and value, and what would be valid.
    """
    file = f"airsim-settings {str(path)!r}"
    try:
        data = read_bounded(path, _MOST_BYTES)
        plain = msgspec.json.decode(data)
    except OSError as error:
        raise TestbenchError(f"{file}: {error.strerror or error}; valid: a file") from None
    except (UnpackError, msgspec.DecodeError, RecursionError, UnicodeDecodeError) as error:
        raise TestbenchError(f"{file} is no JSON: {error}") from None
    if not isinstance(plain, dict):
        raise TestbenchError(f"{file} is {shown(plain)}; valid: an object of JSON")
    return _settings(Fields(plain, file, error=TestbenchError), data.decode())


def _settings(top: Fields, text: str) -> AirsimSettings:
    ignored: list[str] = []
    if top.has("SimMode"):
        top.word("SimMode", ("Multirotor", ""))
    if top.has("SettingsVersion"):
        top.number("SettingsVersion", 1.0, 10.0)
    if top.has("RpcEnabled") and not top.flag("RpcEnabled", default=True):
        top.fail("RpcEnabled", "is false; valid: true, or a run without --airsim-settings")
    if top.has("LocalHostIp"):
        top.word("LocalHostIp", ("127.0.0.1", "localhost"))
    wind, origin = None, None
    if top.has("Wind"):
        wind = Vector3r(*_numbers(top.table("Wind"), ("X", "Y", "Z"), 100.0, "m/s"))
    if top.has("OriginGeopoint"):
        place = top.table("OriginGeopoint")
        origin = (
            place.number("Latitude", -90.0, 90.0, "degrees"),
            place.number("Longitude", -180.0, 180.0, "degrees"),
            place.number("Altitude", -400.0, 9000.0, "m", default=0.0),
        )
        ignored += place.unknown
    lens, lenses = Lens(), {}
    if top.has("CameraDefaults"):
        defaults = top.table("CameraDefaults")
        lens, lenses = _lenses(defaults, Lens(), {}, ignored)
        ignored += defaults.unknown
    shared, table = top.table("DefaultSensors"), top.table("Vehicles")
    vehicles = tuple(
        _vehicle(table.table(name), name, lens, lenses, shared, ignored) for name in _names(table)
    )
    return AirsimSettings(
        vehicles=vehicles,
        lens=lens,
        lenses=lenses,
        clock_speed=top.number("ClockSpeed", 1e-3, 100.0, default=1.0),
        port=top.count("ApiServerPort", 1, 65535) if top.has("ApiServerPort") else PORT,
        wind=wind,
        origin=origin,
        text=text,
        ignored=tuple(dict.fromkeys([*top.unknown, *ignored])),
    )


def _names(table: Fields) -> list[str]:
    """Names that the author of a table has chosen."""
    names = table.names
    if len(names) > _MOST_ENTRIES:
        table.fail(names[_MOST_ENTRIES], f"is one too many; valid: up to {_MOST_ENTRIES}")
    for name in names:
        if not name or len(name) > _MOST_NAME or not is_visible(name):
            table.fail(shown(name), f"is no name; valid: 1 to {_MOST_NAME} characters of one line")
    return names


def _vehicle(
    table: Fields,
    name: str,
    lens: Lens,
    lenses: Mapping[int, Lens],
    shared: Fields,
    ignored: list[str],
) -> VehicleSettings:
    kind = table.text("VehicleType")
    if kind.lower() not in _TYPES:
        valid = "SimpleFlight, PX4Multirotor, ArduCopter"
        table.fail("VehicleType", f"is {shown(kind)}; valid: {valid}")
    has_place = sum(table.has(axis) for axis in "XYZ") > 0  # Each is asked for.
    offset = _numbers(table, ("X", "Y", "Z"), _FAR_M, "m")
    yaw_deg = table.number("Yaw", -_TURN_DEG, _TURN_DEG, "degrees") if table.has("Yaw") else None
    cameras, lidars, distances = table.table("Cameras"), {}, {}
    for sensors in (shared, table.table("Sensors")):
        for sensor in _names(sensors):
            _sensor(sensors.table(sensor), sensor, lidars, distances, ignored)
    settings = VehicleSettings(
        name=name,
        offset_ned_m=offset if has_place else None,
        yaw_deg=yaw_deg,
        is_created=table.flag("AutoCreate", default=True),
        cameras={
            camera: _camera(cameras.table(camera), camera, lens, lenses, ignored)
            for camera in _names(cameras)
        },
        lidars=lidars,
        distances=distances,
    )
    ignored += table.unknown
    return settings


def _sensor(
    table: Fields,
    name: str,
    lidars: dict[str, LidarCfg],
    distances: dict[str, DistanceCfg],
    ignored: list[str],
) -> None:
    """Read a sensor; the vehicle has one barometer, IMU and so on, whatever their names are."""
    kind = table.count("SensorType", 1, _LIDAR)
    if not table.flag("Enabled", default=True):
        if kind not in (_DISTANCE, _LIDAR):
            table.fail("Enabled", "is false; valid: true, because the autopilot flies by it")
        return
    if kind == _DISTANCE:
        distances[name] = DistanceCfg(
            least_m=table.number("MinDistance", 0.0, _FAR_M, "m", default=0.2),
            most_m=table.number("MaxDistance", 0.0, _FAR_M, "m", default=40.0),
            pose=_pose(table),
        )
    elif kind == _LIDAR:
        lidars[name] = _lidar(table)
    ignored += table.unknown


def _lidar(table: Fields) -> LidarCfg:
    turns_hz = table.number("RotationsPerSecond", 0.1, 100.0, "Hz", default=10.0)
    channels = table.count("NumberOfChannels", 1, 256) if table.has("NumberOfChannels") else 16
    points_hz = table.number("PointsPerSecond", 1.0, 2e6, "Hz", default=1e5)
    # A field of view that begins where it ends is the whole turn, as in AirSim.
    first_deg = table.number("HorizontalFOVStart", -_TURN_DEG, _TURN_DEG, "degrees", default=0.0)
    last_deg = table.number("HorizontalFOVEnd", -_TURN_DEG, _TURN_DEG, "degrees", default=359.0)
    return LidarCfg(
        n_channels=channels,
        n_columns=max(1, round(points_hz / turns_hz / channels)),
        range_m=table.number("Range", 0.1, _FAR_M, "m", default=100.0),
        upper_deg=table.number("VerticalFOVUpper", -90.0, 90.0, "degrees", default=-15.0),
        lower_deg=table.number("VerticalFOVLower", -90.0, 90.0, "degrees", default=-45.0),
        first_deg=first_deg,
        last_deg=last_deg,
        pose=_pose(table),
        frame=table.word("DataFrame", FRAMES) if table.has("DataFrame") else FRAMES[0],
    )


def _camera(
    table: Fields, name: str, lens: Lens, lenses: Mapping[int, Lens], ignored: list[str]
) -> Camera:
    own, own_lenses = _lenses(table, lens, lenses, ignored)
    camera = Camera(name=name, pose=_pose(table), lens=own, lenses=own_lenses)
    ignored += table.unknown
    return camera


def _lenses(
    table: Fields, lens: Lens, lenses: Mapping[int, Lens], ignored: list[str]
) -> tuple[Lens, dict[int, Lens]]:
    """Lenses of a camera by image type; image type 0 is also that of types without an entry."""
    found = {kind: replace(each) for kind, each in lenses.items()}
    if not table.has("CaptureSettings"):
        return replace(lens), found
    for entry in table.tables("CaptureSettings"):
        kind = entry.count("ImageType", 0, 10) if entry.has("ImageType") else 0
        base = found.get(kind, lens)
        width = entry.count("Width", 1, MOST_PX) if entry.has("Width") else base.width_px
        height = entry.count("Height", 1, MOST_PX) if entry.has("Height") else base.height_px
        fov_deg = entry.number("FOV_Degrees", 1.0, 170.0, "degrees", default=base.fov_deg)
        found[kind] = Lens(width_px=width, height_px=height, fov_deg=fov_deg)
        ignored += entry.unknown
    return replace(lens), found


def _pose(table: Fields) -> Pose:
    """Pose of a part on the vehicle, forward-right-down."""
    roll, pitch, yaw = (
        math.radians(table.number(axis, -_TURN_DEG, _TURN_DEG, "degrees", default=0.0))
        for axis in ("Roll", "Pitch", "Yaw")
    )
    return Pose(Vector3r(*_numbers(table, ("X", "Y", "Z"), 10.0, "m")), quat_frd(roll, pitch, yaw))


def _numbers(table: Fields, names: tuple[str, str, str], most: float, unit: str) -> Vector3:
    x, y, z = (table.number(name, -most, most, unit, default=0.0) for name in names)
    return x, y, z
