"""Settings of a testbench: vehicle, seed, air, sensors, speed, ports, and the flight stack.

The fields are the options of `aeroscene sitl` and of other commands, so their docstrings are its
help. A field that has a syntax of its own, such as the traffic, stays text here; a property parses
it. All of them are parsed once at the start, so that a wrong option costs no building of a scene.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Annotated, Literal

import numpy as np

from aeroscene.ranges import SEEDS, Range, require_ranges
from flightsim.autopilot.environment_parameters import wind_parameters
from flightsim.bridges import STACKS
from flightsim.cameras.optics import (
    EXPOSURE_EV,
    GAMMA,
    NOISE_LEVELS,
    SHUTTER_MS,
    OpticsCfg,
    parse_distortion,
)
from flightsim.environment.effects import Effects
from flightsim.environment.traffic import TrafficCfg
from flightsim.environment.wind import MAX_GUST_MPS, MAX_WIND_MPS, WindCfg, turbulence_mps
from flightsim.lidars import lidar_by_name
from flightsim.looks.weather import RANDOM, Season, Weather, draw_weather, parse_weather
from flightsim.mavlink.links import LinkError, OutAddress, SerialLine
from flightsim.mavlink.personalities import PERSONALITIES
from flightsim.mavlink.signing import Signing, SigningKeyError, read_key
from flightsim.plant import PlantCfg
from flightsim.plant.timed_failures import TimedFailure, parse_failures
from flightsim.sensors.optical_flow import OpticalFlowCfg
from flightsim.vehicles import airframe_by_name
from flightsim.vehicles.camera_options import with_cameras

MAX_INSTANCES = 100
_LEAST_PX, _MOST_PX = 16, 4096
_LIGHT_STREAM = 0x11647
_TICKS_PER_BURST = 10
"""Ticks whose telemetry leaves together at full speed, where they take about a millisecond.

To send a datagram costs 4 us of CPU, and 12 more if it wakes its reader; together they wake it once
in ten ticks.
"""


class TestbenchError(ValueError):
    """No testbench can be built from the settings."""


@dataclass(frozen=True, kw_only=True)
class TestbenchCfg:
    """Settings of a simulation."""

    vehicle: str = "iris"
    """Airframe by its name, or a file FILE.toml that describes one (docs/airframes.md); an unknown
    name is answered with the valid ones."""
    seed: Annotated[int, SEEDS] = 0
    """Seed of every random draw: sensor noise, choice of the landing area."""
    gnss: Literal["rtk", "standard"] = "rtk"
    """GNSS grade: rtk has decimetre errors, standard metres."""
    aiding: Literal["gnss", "vio", "mocap", "auto"] = "auto"
    """Position source: gnss (not in rooms), vio (visual-inertial odometry), mocap (motion capture),
    or auto, which is GNSS under open sky and VIO everywhere."""
    wind: Annotated[float, Range(0.0, MAX_WIND_MPS, "m/s")] = 0.0
    """Speed of the steady wind."""
    wind_from: Annotated[float, Range(-360.0, 360.0, "degrees")] = 270.0
    """Direction of the wind's origin, clockwise from north: 270 is the west."""
    turbulence: str = "none"
    """Dryden turbulence: none, natural (by the steady wind), light, moderate, severe, or the
    standard deviation of its vertical part in m/s."""
    gust: Annotated[float, Range(0.0, MAX_GUST_MPS, "m/s")] = 0.0
    """Peak speed that a gust adds to the wind; 3 s of every 15 s."""
    traffic: str = "none"
    """Movers besides the vehicle, such as people=3,cars=2,drones=1."""
    fail: str = "none"
    """Parts that fail in flight, such as gnss=off@5,motor1=off@8: the part, how it fails, and the
    seconds after lift-off. See docs/failures.md."""
    depth_camera: Literal["exact", "d435", "d455"] = "exact"
    """Depth of the cameras: exact, or with the errors of a RealSense D435 or D455."""
    camera_size: str = "320x240"
    """Width and height of the images of the vehicle's cameras in pixels, 16 to 4096 each."""
    camera: tuple[str, ...] = ()
    """Cameras to change or to add, such as forward,fov=90,pitch=10 or left,yaw=90,x=0.1,y=0.05,z=0;
    degrees, and metres from the centre of mass. See docs/sensors.md."""
    light: str = ""
    """Time of day and weather of camera images: terms with commas between them, such as dusk, fog
    80 m or 11:30, rain, or random, which the seed draws; by default a fair afternoon. It changes
    colours alone. See docs/light.md."""
    season: Season = "summer"
    """Season of leaves, grass and the date of the light: spring, summer, autumn or winter."""
    camera_exposure: Annotated[float, EXPOSURE_EV] = 0.0
    """Exposure of the cameras' colours: each unit doubles the light."""
    camera_gamma: Annotated[float, GAMMA] = 1.0
    """Gamma of the cameras' colours: above 1 is brighter, below is darker."""
    camera_motion_blur: Annotated[float, SHUTTER_MS] = 0.0
    """Time for which each pixel of the colours gathers light."""
    camera_rolling_shutter: Annotated[float, SHUTTER_MS] = 0.0
    """Time from the first row of the colours to the last."""
    camera_distortion: str = "none"
    """Distortion of the colours by the lens: K1[,K2[,P1[,P2]]] of Brown and Conrady, such as
    -0.2,0.05. Depth and labels stay a pinhole's. See docs/sensors.md."""
    camera_noise: Annotated[float, NOISE_LEVELS] = 0.0
    """Noise of the cameras' colours: standard deviation of mid-grey."""
    segmentation: bool = False
    """Give frames of the cameras the object and the class of each pixel."""
    lidar: str = ""
    """Lidar to carry: vlp16, mid40, or a file FILE.toml or FILE.csv; see docs/sensors.md."""
    optical_flow: bool = False
    """Carry a sensor of optical flow that looks down, with its MAVLink messages."""
    without: str = ""
    """Effects of the physics to leave out, such as ground,ceiling; docs/physics.md names them."""
    free_flight: bool = True
    """Integrate a vehicle without MuJoCo while nothing can touch it: faster, and the same flight up
    to rounding. See docs/physics.md."""
    speed: Annotated[float | Literal["max"], Range(0.0, is_above=True, word="max")] = 1.0
    """Simulated seconds per wall second, or max for as fast as it goes."""
    instance: Annotated[int, Range(0, MAX_INSTANCES - 1)] = 0
    """Number of this vehicle: shifts every port and the MAVLink system id (1 + instance)."""
    bind: str = "127.0.0.1"
    """Address that the MAVLink ports listen on; 0.0.0.0 opens them to the network."""
    out: tuple[str, ...] = ()
    """Address elsewhere to which the vehicle speaks first, udp:HOST:PORT, such as
    udp:192.168.1.20:14550 for a QGroundControl there; once for each address."""
    serial: str = ""
    """Serial device for one more client, PATH or PATH:BAUD, such as /dev/ttyUSB0:57600."""
    signing_key: str = ""
    """File whose line is a passphrase as ground stations take it: messages are signed with its key,
    and others are refused; without it clients may set one. See docs/connect.md."""
    personality: str = "px4"
    """Flight stack whose modes, parameters and habits clients meet: px4 or ardupilot."""
    autopilot: Literal["builtin", "px4", "ardupilot"] = "builtin"
    """Flight stack that flies: our own autopilot, or PX4 or ArduPilot itself, which runs in
    lockstep with our physics; see docs/flight_stacks.md."""
    autopilot_binary: str = ""
    """Program of that flight stack, which is started and ended with the run; without it the run
    waits for one that you start."""
    lockstep: bool = False
    """Let time wait for a client that grants every tick, so that its flight can be repeated bit for
    bit; the run ends when it leaves. See docs/lockstep.md."""

    def __post_init__(self) -> None:
        """Refuse invalid settings before anything is built.

        Raises:
            ValueError: If one is invalid; the line names the option, its value, and what is valid.
                Each part of the package has its own subclass.
        """
        require_ranges(self, TestbenchError)
        with_cameras(airframe_by_name(self.vehicle), self.camera)
        if self.lidar:
            lidar_by_name(self.lidar)
        _ = self.camera_size_px, self.weather, self.optics
        _ = (
            self.wind_cfg,
            self.traffic_cfg,
            self.timed_failures,
            self.effects,
            self.serial_line,
            self.signing,
        )
        _ = self.out_addresses
        if self.personality not in PERSONALITIES:
            raise TestbenchError(
                f"personality {self.personality!r} is unknown; valid: {', '.join(PERSONALITIES)}"
            )
        self._check_autopilot()

    def _check_autopilot(self) -> None:
        """Refuse settings that only our autopilot has, where another one flies."""
        if self.autopilot == "builtin":
            if self.autopilot_binary:
                raise TestbenchError(
                    f"autopilot-binary {self.autopilot_binary!r} needs an autopilot; "
                    f"valid: --autopilot {' or '.join(STACKS)}"
                )
            return
        for name in ("lockstep", "out", "serial", "signing_key"):
            if value := getattr(self, name):
                shown = ", ".join(value) if isinstance(value, tuple) else value
                raise TestbenchError(
                    f"{name.replace('_', '-')} {shown} is our autopilot's, and "
                    f"{self.autopilot} flies; valid: --autopilot builtin"
                )

    @property
    def weather(self) -> Weather:
        """Time of day, weather and season of camera images; random ones follow from the seed.

        Raises:
            WeatherError: If the words name none.
        """
        if self.light.strip().lower() != RANDOM:
            return parse_weather(self.light, self.season)
        # A stream of its own, so that a choice of light moves no other draw of the flight.
        return draw_weather(np.random.default_rng([_LIGHT_STREAM, self.seed]), self.season)

    @property
    def wind_cfg(self) -> WindCfg:
        """Wind of these settings.

        Raises:
            WindError: If it is invalid.
        """
        return WindCfg(
            speed_mps=self.wind,
            from_deg=self.wind_from,
            turbulence_mps=turbulence_mps(self.turbulence, self.wind),
            gust_mps=self.gust,
        )

    @property
    def traffic_cfg(self) -> TrafficCfg:
        """Traffic of these settings.

        Raises:
            TrafficError: If it is invalid.
        """
        return TrafficCfg.parse(self.traffic, self.seed)

    @property
    def timed_failures(self) -> tuple[TimedFailure, ...]:
        """Failures in flight of these settings.

        Raises:
            TimedFailureError: If one is invalid.
        """
        return parse_failures(self.fail, len(airframe_by_name(self.vehicle).motors))

    @property
    def effects(self) -> Effects:
        """Effects of the physics that these settings leave in.

        Raises:
            EffectError: If there is no effect of a name.
        """
        return Effects.without(self.without)

    @property
    def camera_size_px(self) -> tuple[int, int]:
        """Width and height of the cameras' images, in pixels.

        Raises:
            TestbenchError: If they are no size, or out of range.
        """
        parts = self.camera_size.split("x")
        # `isdecimal` admits no sign, no space and no underscore, all of which int() takes.
        is_size = len(parts) == 2 and all(part.isdecimal() for part in parts)
        sizes = [int(part) for part in parts] if is_size else []
        if not is_size or not all(_LEAST_PX <= px <= _MOST_PX for px in sizes):
            raise TestbenchError(
                f"camera-size {self.camera_size!r} is not valid; valid: WIDTHxHEIGHT of "
                f"{_LEAST_PX} to {_MOST_PX} pixels, such as 640x480"
            )
        return sizes[0], sizes[1]

    @property
    def optics(self) -> OpticsCfg:
        """Lens and sensor of the cameras' colours.

        Raises:
            OpticsError: If the distortion is invalid.
        """
        return OpticsCfg(
            exposure_ev=self.camera_exposure,
            gamma=self.camera_gamma,
            motion_blur_ms=self.camera_motion_blur,
            rolling_shutter_ms=self.camera_rolling_shutter,
            distortion=parse_distortion(self.camera_distortion),
            noise_levels=self.camera_noise,
        )

    @property
    def serial_line(self) -> SerialLine | None:
        """Serial device of these settings, if there is one.

        Raises:
            TestbenchError: If its speed is unknown.
        """
        try:
            return SerialLine.parse(self.serial) if self.serial else None
        except LinkError as error:
            raise TestbenchError(str(error)) from error

    @property
    def out_addresses(self) -> tuple[OutAddress, ...]:
        """Addresses to which the vehicle speaks first.

        Raises:
            TestbenchError: If one is no address, or its host is unknown.
        """
        try:
            return tuple(map(OutAddress.parse, self.out))
        except LinkError as error:
            raise TestbenchError(str(error)) from error

    @property
    def signing(self) -> Signing:
        """Signing of the network and serial links, with the key of these settings, if any.

        Raises:
            TestbenchError: If the file of the key holds none.
        """
        try:
            return Signing(read_key(self.signing_key) if self.signing_key else None)
        except SigningKeyError as error:
            raise TestbenchError(str(error)) from error

    @property
    def initial_parameters(self) -> Mapping[str, float]:
        """Parameters of the autopilot that these settings change from their defaults."""
        return {
            **PERSONALITIES[self.personality].initial_parameters,
            "MAV_SYS_ID": 1 + self.instance,  # instances count from 0, ids from 1
            **wind_parameters(self.wind_cfg),
        }

    @property
    def ticks_per_burst(self) -> int:
        """Number of ticks whose telemetry leaves together; 1 wherever a client may wait for it."""
        # At any other speed a tick takes longer than a client should wait for its telemetry.
        return _TICKS_PER_BURST if self.speed == "max" and not self.lockstep else 1

    @property
    def plant_cfg(self) -> PlantCfg:
        """Settings of the plant that follow from these."""
        cfg = PlantCfg(
            seed=self.seed,
            gnss=self.gnss,
            aiding=self.aiding,
            wind=self.wind_cfg,
            effects=self.effects,
            free_flight=self.free_flight,
            optical_flow=OpticalFlowCfg(is_fitted=self.optical_flow),
        )
        # An external stack sets the rate of the exchanges, which are one per control tick.
        stack = STACKS.get(self.autopilot)
        return cfg if stack is None else replace(cfg, control_hz=stack.rate_hz)
