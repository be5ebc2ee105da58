"""Calls about the whole run: connection, time, wind, weather, objects, messages."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping, Sequence

from aeroscene.files.visible import visible
from scenarios.airsim.clock import Clock
from scenarios.airsim.craft import Craft
from scenarios.airsim.frames import geo, pose
from scenarios.airsim.messages import GeoPoint, Pose, Quaternionr, Vector3r
from scenarios.airsim.methods import Later, RpcError, all_of
from scenarios.airsim.objects import Objects
from scenarios.airsim.weather import Weather, set_wind

_LOG = logging.getLogger(__name__)

SERVER_VERSION, LEAST_CLIENT_VERSION = 4, 1
"""Cosys-AirSim's clients want a server of version 4; those of AirSim are of version 1."""
_MOST_TEXTS, _MOST_TEXT = 100, 200
_NAN = float("nan")


class WorldCalls:
    """Methods by their names in AirSim that name no vehicle."""

    def __init__(
        self,
        crafts: Sequence[Craft],
        objects: Objects,
        clock: Clock,
        weather: Weather,
        settings_text: str,
        waiting_names: frozenset[str],
    ) -> None:
        """Answer for a run.

        Args:
            crafts: Its vehicles.
            objects: What else is in it.
            clock: Holds time.
            weather: Fog and dust.
            settings_text: What a client gets that asks for the settings.
            waiting_names: Vehicles that exist only once a client has added them.
        """
        self._crafts, self._objects, self._clock = crafts, objects, clock
        self._weather, self._settings_text = weather, settings_text
        self._waiting = set(waiting_names)
        self._n_texts = 0
        self._drawing: set[str] = set()

    @property
    def functions(self) -> Mapping[str, Callable[..., object]]:
        """All methods."""
        return {
            "ping": self.ping,
            "getServerVersion": lambda: SERVER_VERSION,
            "getMinRequiredClientVersion": lambda: LEAST_CLIENT_VERSION,
            "reset": self.reset,
            "simPause": self.pause,
            "simIsPaused": self.is_paused,
            "simContinueForTime": self._clock.go_on,
            "simContinueForFrames": self._clock.go_on_for,
            "simSetWind": self.wind,
            "simEnableWeather": self.enable_weather,
            "simSetWeatherParameter": self.weather,
            "simPrintLogMessage": self.print_message,
            "listVehicles": self.vehicles,
            "simAddVehicle": self.add_vehicle,
            "getSettingsString": lambda: self._settings_text,
            "simListSceneObjects": self.objects,
            "simGetObjectPose": self.object_pose,
            "simGetObjectScale": self.object_scale,
            "simGetSegmentationObjectID": self._objects.segment_of,
            "simSetSegmentationObjectID": self.set_segment,
            "simListInstanceSegmentationObjects": self.segmented,
            "simListInstanceSegmentationPoses": self.segmented_poses,
            "simGetWorldExtents": self.extents,
        }

    def ping(self) -> bool:
        """Return True, to show that the run answers."""
        return True

    def reset(self) -> Later | None:
        """Put all vehicles back to their starts; while time stands still, once it goes on."""
        answers = [craft.flyer.renew() for craft in self._crafts]
        return None if self._clock.is_paused else all_of(answers)

    def pause(self, is_paused: bool) -> None:
        """Stop time, or let it pass."""
        self._clock.pause(is_paused=is_paused)

    def is_paused(self) -> bool:
        """Return True if time stands still."""
        return self._clock.is_paused

    def wind(self, wind: Vector3r) -> None:
        """Let a wind blow, m/s north, east and down."""
        set_wind([craft.vehicle.plant for craft in self._crafts], wind)

    def enable_weather(self, enable: bool) -> None:
        """Show the weather or not."""
        self._weather.enable(is_enabled=enable)

    def weather(self, param: int, val: float) -> None:
        """Set fog or dust."""
        self._weather.set(param, val)

    def print_message(self, message: str, message_param: str = "", severity: int = 0) -> None:
        """Show a client's words; a flood of them is cut off."""
        self._n_texts += 1
        if self._n_texts > _MOST_TEXTS:
            return
        level = logging.WARNING if severity > 0 else logging.INFO
        _LOG.log(level, "AirSim client: %s", visible(f"{message}{message_param}"[:_MOST_TEXT]))
        if self._n_texts == _MOST_TEXTS:
            _LOG.warning("AirSim: further messages of clients are not shown")

    def vehicles(self) -> list[str]:
        """Names of the vehicles."""
        return [craft.name for craft in self._crafts if craft.name not in self._waiting]

    def add_vehicle(
        self, vehicle_name: str, vehicle_type: str, pose: Pose, pawn_path: str = ""
    ) -> bool:
        """Add a vehicle that the settings hold ready; it stands where they say.

        Raises:
            RpcError: If the settings have none of this name.
        """
        _ = vehicle_type, pose, pawn_path
        if vehicle_name in self._waiting:
            self._waiting.discard(vehicle_name)
            return True
        if any(craft.name == vehicle_name for craft in self._crafts):
            return False
        raise RpcError(
            f"vehicle {vehicle_name[:80]!r} cannot be added to a run; valid: one that the settings "
            'have with "AutoCreate": false'
        )

    def objects(self, name_regex: str = ".*") -> list[str]:
        """Names of what is in the world."""
        return self._objects.named(name_regex)

    def object_pose(self, object_name: str, ned: bool = True) -> Pose:
        """Pose of a thing in the world, from where the first vehicle started; NaN without one."""
        if not ned:
            raise RpcError("ned False is not offered; valid: True")
        found = self._objects.pose(object_name)
        if found is None:
            return Pose(Vector3r(_NAN, _NAN, _NAN), Quaternionr(_NAN, _NAN, _NAN, _NAN))
        position, quat = found
        return Pose(self._crafts[0].local(position), pose(position, quat).orientation)

    def object_scale(self, object_name: str) -> Vector3r:
        """Scale of a thing: 1, since nothing is scaled; NaN without one."""
        is_there = self._objects.pose(object_name) is not None
        return Vector3r(1.0, 1.0, 1.0) if is_there else Vector3r(_NAN, _NAN, _NAN)

    def set_segment(self, mesh_name: str, object_id: int, is_name_regex: bool = False) -> bool:
        """Give objects a number for segmentation."""
        return self._objects.set_segment(mesh_name, object_id, is_pattern=is_name_regex)

    def segmented(self) -> list[str]:
        """Names of everything that has a number for segmentation."""
        return self._objects.named(".*")

    def segmented_poses(self, ned: bool = True, only_visible: bool = False) -> list[Pose]:
        """Poses in the same order."""
        _ = only_visible
        return [self.object_pose(name, ned) for name in self.segmented()]

    def extents(self) -> list[GeoPoint]:
        """Corners of the flight volume."""
        vehicle = self._crafts[0].vehicle
        scene, frame = vehicle.scene, vehicle.frame
        corners = (scene.extent_min_enu_m, scene.extent_max_enu_m)
        return [geo(frame.geodetic_from_enu(corner)) for corner in corners]
