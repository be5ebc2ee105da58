"""Testbench: a scene with a vehicle, its autopilot and its MAVLink, in one loop."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, Self

from aeroscene.scene import Scene
from flightsim.autopilot.autopilot import Autopilot
from flightsim.environment.effects import Effects
from flightsim.environment.movers import MovingObstacle
from flightsim.environment.parameters import follow_parameters, wind_parameters
from flightsim.environment.traffic import TrafficCfg
from flightsim.environment.wind import WindCfg, turbulence_mps
from flightsim.frames import Geodetic, LocalFrame
from flightsim.mavlink.client import MavlinkClient
from flightsim.mavlink.links import InProcessLink, Link, TcpServerLink, UdpLink
from flightsim.mavlink.personalities import PERSONALITIES
from flightsim.mavlink.server import MavlinkServer
from flightsim.plant import Plant, PlantCfg
from flightsim.simulator import Simulator
from flightsim.vehicles import Airframe, airframe_by_name
from flightsim.world import World, build_world

MAX_INSTANCES = 100
_TICKS_PER_DATAGRAM = 3
"""Number of ticks whose telemetry shares a datagram at full speed, where they take less than a
millisecond: as many as fill one for a companion. Sending costs more than all else for a client."""


class TestbenchError(ValueError):
    """No testbench can be built from the configuration."""


@dataclass(frozen=True, kw_only=True)
class TestbenchCfg:
    """Settings of a simulation."""

    vehicle: str = "iris"
    """Airframe by its name; an unknown one is answered with the valid names."""
    seed: int = 0
    """Seed of every random draw: sensor noise, choice of the landing area."""
    gnss: Literal["rtk", "standard"] = "rtk"
    """GNSS grade: rtk has decimetre errors, standard metres."""
    aiding: Literal["gnss", "vio", "mocap", "auto"] = "auto"
    """Position source: gnss (not in rooms), vio (visual-inertial odometry), mocap (motion capture),
    or auto, which is GNSS under open sky and VIO everywhere."""
    wind: float = 0.0
    """Speed of the steady wind, m/s."""
    wind_from: float = 270.0
    """Direction of the wind's origin in degrees clockwise from north: 270 is the west."""
    turbulence: str = "none"
    """Dryden turbulence: none, natural (by the steady wind), light, moderate, severe, or the
    standard deviation of its vertical part in m/s."""
    gust: float = 0.0
    """Peak speed that a gust adds to the wind, m/s; 3 s of every 15 s."""
    traffic: str = "none"
    """Movers besides the vehicle, such as people=3,cars=2,drones=1."""
    depth_camera: Literal["exact", "d435", "d455"] = "exact"
    """Depth of the cameras: exact, or with the errors of a RealSense D435 or D455."""
    without: str = ""
    """Effects of the physics to leave out, such as ground,ceiling; docs/physics.md names them."""
    speed: float | Literal["max"] = 1.0
    """Simulated seconds per wall second, or max for as fast as it goes."""
    instance: int = 0
    """Number of this vehicle: shifts every port and the MAVLink system id (1 + instance)."""
    bind: str = "127.0.0.1"
    """Address that the MAVLink ports listen on; 0.0.0.0 opens them to the network."""
    personality: str = "px4"
    """Flight stack whose modes, parameters and habits clients meet: px4 or ardupilot."""
    lockstep: bool = False
    """Let time wait for a client that grants every tick, so that its flight can be repeated bit for
    bit; the run ends when it leaves. See docs/lockstep.md."""

    def __post_init__(self) -> None:
        """Refuse invalid settings before anything is built."""
        airframe_by_name(self.vehicle)
        _ = self.wind_cfg, self.traffic_cfg, self.effects
        if self.speed != "max" and not 0.0 < self.speed < float("inf"):
            raise TestbenchError(f"speed {self.speed} is not positive; valid: 1, a factor, or max")
        if not 0 <= self.instance < MAX_INSTANCES:
            raise TestbenchError(
                f"instance {self.instance} is out of range; valid: 0 to {MAX_INSTANCES - 1}"
            )
        if self.personality not in PERSONALITIES:
            raise TestbenchError(
                f"personality {self.personality!r} is unknown; valid: {', '.join(PERSONALITIES)}"
            )
        if self.seed < 0:
            raise TestbenchError(f"seed {self.seed} is negative; valid: 0 or more")

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
    def effects(self) -> Effects:
        """Physics of these settings.

        Raises:
            EffectError: If there is no effect of a name.
        """
        return Effects.without(self.without)

    @property
    def initial_parameters(self) -> Mapping[str, float]:
        """The autopilot's parameters that these settings change from their defaults."""
        return {
            **PERSONALITIES[self.personality].initial_parameters,
            "MAV_SYS_ID": 1 + self.instance,
            **wind_parameters(self.wind_cfg),
        }

    @property
    def ticks_per_datagram(self) -> int:
        """Number of ticks whose telemetry shares a datagram."""
        return _TICKS_PER_DATAGRAM if self.speed == "max" and not self.lockstep else 1

    @property
    def plant_cfg(self) -> PlantCfg:
        """Plant of these settings."""
        return PlantCfg(
            seed=self.seed,
            gnss=self.gnss,
            aiding=self.aiding,
            wind=self.wind_cfg,
            effects=self.effects,
        )


class Testbench:
    """Builds every part of a run and owns what must be closed.

    Attributes:
        simulator: Simulation loop; its `run` and `step` advance time.
        pilot_link: Lockstep MAVLink for a companion inside this process.
        observers: Called in this order at the end of each tick; append functions to watch.
    """

    def __init__(
        self,
        scene: Scene,
        cfg: TestbenchCfg,
        *,
        airframe: Airframe | None = None,
        traffic: Sequence[MovingObstacle] | None = None,
        has_network: bool = True,
        extra_links: Sequence[Link] = (),
    ) -> None:
        """Build the world of a scene and open the links.

        Args:
            scene: Scene to fly in.
            cfg: Settings of the simulation.
            airframe: Vehicle of one's own instead of the configured one.
            traffic: Movers on paths of their own instead of the configured ones.
            has_network: Whether clients outside this process can connect.
            extra_links: MAVLink links besides the in-process one and the network's.

        Raises:
            WorldError: If the vehicle cannot start there.
            TrafficError: If the scene has no room for the traffic.
            PortInUseError: If a MAVLink port is taken.
        """
        self.cfg = cfg
        self.scene = scene
        self.airframe = airframe or airframe_by_name(cfg.vehicle)
        self.world: World = build_world(
            self.scene, self.airframe, traffic=cfg.traffic_cfg if traffic is None else traffic
        )
        self.plant = Plant(self.world, cfg.plant_cfg)
        self.frame = LocalFrame(
            Geodetic(self.scene.latitude_deg, self.scene.longitude_deg, self.scene.altitude_m)
        )
        self.autopilot = Autopilot(
            self.plant,
            self.frame,
            airframe=self.airframe,
            initial_parameters=cfg.initial_parameters,
        )
        follow_parameters(self.autopilot.parameters, self.plant)
        self.pilot_link = InProcessLink()
        links: list[Link] = [self.pilot_link, *extra_links]
        if has_network:
            links += network_links(cfg.instance, cfg.bind, is_lockstep=cfg.lockstep)
        self.server = MavlinkServer(
            self.autopilot,
            self.plant,
            self.frame,
            links,
            system_id=1 + cfg.instance,
            personality=PERSONALITIES[cfg.personality],
            has_lockstep=cfg.lockstep,
            ticks_per_datagram=cfg.ticks_per_datagram,
        )
        self.observers: list[Callable[[], None]] = []
        self.simulator = Simulator(
            self.plant, self.autopilot, self.server, observers=self.observers, speed=cfg.speed
        )

    @property
    def is_over(self) -> bool:
        """Whether a client that kept the time has left, so that no more of it will pass."""
        lockstep = self.server.lockstep
        return lockstep is not None and lockstep.is_over

    def connect(self) -> MavlinkClient:
        """Create a companion on `pilot_link`; `update` it with `plant.time_us` after each tick."""
        return MavlinkClient(self.pilot_link.client, self.frame)

    def run(self, seconds: float, until: Callable[[], bool] | None = None) -> None:
        """Advance simulated time at the configured speed, until `until()` holds if it is given."""
        self.simulator.run(until_us=self.plant.time_us + round(seconds * 1e6), stop=until)

    def close(self) -> None:
        """Close every link."""
        self.server.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()


def network_links(instance: int, bind: str, *, is_lockstep: bool = False) -> list[Link]:
    """MAVLink ports of both flight stacks' simulators.

    UDP to 14550 and 14540 as PX4 has it, TCP servers on 5760, 5762 and 5763 as ArduPilot has them.
    """
    return [
        UdpLink(
            local_port=18570 + instance,
            remote_port=14550 + instance,
            bind_address=bind,
            is_lockstep=is_lockstep,
        ),
        UdpLink(
            local_port=14580 + instance,
            remote_port=14540 + instance,
            profile="onboard",
            bind_address=bind,
            is_lockstep=is_lockstep,
        ),
        *(
            TcpServerLink(port=port + 10 * instance, bind_address=bind, is_lockstep=is_lockstep)
            for port in (5760, 5762, 5763)
        ),
    ]
