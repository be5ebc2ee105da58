"""Several vehicles in one world, each with a stack and links of its own, in one loop."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import Self

from aeroscene.scene import Scene
from flightsim.mavlink.links import Link
from flightsim.plant import Plant
from flightsim.simulator import Controller, Server, Simulator
from flightsim.testbench.cfg import MAX_INSTANCES, TestbenchCfg, TestbenchError
from flightsim.testbench.testbench import Testbench
from flightsim.vehicles import Airframe
from flightsim.vehicles.builder import vehicle_name
from flightsim.world import build_world


class SharedTestbench:
    """Testbenches of the vehicles of one world, which fly together.

    Vehicle i is instance `cfg.instance` + i: its system id and its ports follow from that, as if
    it had been started alone. The first one has what there can be only once, such as a serial line.

    Attributes:
        benches: Testbench of each vehicle, with its plant, its stack, and its observers.
        simulator: The loop of all.
    """

    def __init__(
        self,
        scene: Scene,
        cfg: TestbenchCfg,
        airframes: Sequence[Airframe],
        *,
        has_network: bool = True,
        links: Sequence[Sequence[Link]] = (),
        captures: Path | None = None,
        has_video: bool = False,
    ) -> None:
        """Build the world and open the links of every vehicle, or nothing.

        Args:
            scene: Scene to fly in; the first vehicle has its start, the others places beside it.
            cfg: Settings of all; its `vehicle` is not asked.
            airframes: The vehicles, at least one.
            has_network: Whether clients outside this process can connect.
            links: MAVLink links of one's own besides, for the first vehicle, the second and so on.
            captures: Folder for photographs and films, with a folder for each vehicle.
            has_video: Whether each gimbal's picture is streamed, to a port of its instance.

        Raises:
            WorldError: If the start has not enough room, or a vehicle cannot stand.
            TrafficError: If the scene has no room for the traffic.
            PortInUseError: If a MAVLink port is taken.
            TestbenchError: If vehicles of another flight stack are asked for, or too many.
        """
        cfgs = _cfgs(cfg, airframes)
        world = build_world(scene, *airframes, traffic=cfg.traffic_cfg)
        self.cfg, self.scene = cfg, scene
        self.plant = Plant(world, cfg.plant_cfg)
        plants = (self.plant, *self.plant.mates)
        if captures is not None:
            captures.mkdir(exist_ok=True)
        with ExitStack() as stack:
            self.benches = tuple(
                stack.enter_context(
                    Testbench(
                        plant.world.scene,
                        each,
                        plant=plant,
                        has_network=has_network,
                        extra_links=links[i] if i < len(links) else (),
                        captures=None if captures is None else captures / vehicle_name(i),
                        has_video=has_video,
                    )
                )
                for i, (each, plant) in enumerate(zip(cfgs, plants, strict=True))
            )
            self._stack = stack.pop_all()
        self.observers: list[Callable[[], None]] = []
        """Called after those of all benches, at the end of each tick."""
        self.simulator = Simulator(
            self.plant,
            _Controllers([bench.parts[0] for bench in self.benches]),
            _Servers([bench.parts[1] for bench in self.benches]),
            observers=[self._observe],
            speed=cfg.speed,
        )
        for bench in self.benches:
            bench.simulator = self.simulator

    def _observe(self) -> None:
        for bench in self.benches:
            for observer in bench.observers:
                observer()
        for observer in self.observers:
            observer()

    @property
    def fault(self) -> str:
        """What keeps time from passing for good, in words; empty while it passes."""
        return next((fault for bench in self.benches if (fault := bench.stack.fault)), "")

    def run(self, seconds: float, until: Callable[[], bool] | None = None) -> None:
        """Advance simulated time at the configured speed, until `until()` holds if it is given."""
        self.simulator.run(until_us=self.plant.time_us + round(seconds * 1e6), stop=until)

    def close(self) -> None:
        """Close every link."""
        self._stack.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()


class _Controllers:
    """The controllers of all vehicles."""

    def __init__(self, controllers: Sequence[Controller]) -> None:
        self._controllers = controllers

    def update(self) -> None:
        for controller in self._controllers:
            controller.update()


class _Servers:
    """The servers of all vehicles; time passes when each of them lets it."""

    def __init__(self, servers: Sequence[Server]) -> None:
        self._servers = servers

    def update(self) -> None:
        for server in self._servers:
            server.update()

    def wait_for_tick(self, timeout_s: float) -> bool:
        return all(server.wait_for_tick(timeout_s) for server in self._servers)


def _cfgs(cfg: TestbenchCfg, airframes: Sequence[Airframe]) -> list[TestbenchCfg]:
    """Settings of each vehicle."""
    if cfg.autopilot != "builtin" and len(airframes) > 1:
        raise TestbenchError(
            f"vehicles {len(airframes)} are our autopilot's, and {cfg.autopilot} flies; valid: "
            "--autopilot builtin, or one vehicle"
        )
    last = cfg.instance + len(airframes) - 1
    if last >= MAX_INSTANCES:
        raise TestbenchError(
            f"vehicles {len(airframes)} from instance {cfg.instance} on reach instance {last}; "
            f"valid: up to {MAX_INSTANCES - 1}"
        )
    return [
        replace(
            cfg,
            vehicle=airframe.vehicle,
            instance=cfg.instance + i,
            serial="" if i else cfg.serial,
        )
        for i, airframe in enumerate(airframes)
    ]
