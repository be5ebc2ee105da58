"""One run of several vehicles in one world: each with its pilot, its verdict and its log."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

from aeroscene.scene import Scene
from flightsim.mavlink.links import Link
from flightsim.testbench import SharedTestbench
from flightsim.vehicles.builder import vehicle_name
from scenarios.mission.goals import find_area, with_start
from scenarios.run.among import Among
from scenarios.run.cfg import SitlCfg
from scenarios.run.hangar import Hangar
from scenarios.run.missions import plan_missions
from scenarios.run.schedule import RunClock, run_until_over
from scenarios.run.sitl import Sitl
from scenarios.trials.result import TrialResult

if TYPE_CHECKING:
    from scenarios.recording.viewer import Viewer


@dataclass(frozen=True, kw_only=True, slots=True)
class SharedResult:
    """Results of all vehicles of a run, the first one first."""

    first_system: int
    """MAVLink system id of the first vehicle; those of the others follow."""
    vehicles: tuple[TrialResult, ...]

    @property
    def success(self) -> bool | None:
        """Whether all flights are done; None where nobody flew."""
        said = [result.success for result in self.vehicles]
        return None if None in said else all(said)

    @property
    def reason(self) -> str:
        """How each flight ended, in words."""
        return "; ".join(f"vehicle {i + 1}: {r.reason}" for i, r in enumerate(self.vehicles))

    @property
    def state_hash(self) -> str:
        """Hash of every state of all flights."""
        hashes = "".join(result.state_hash for result in self.vehicles)
        return hashlib.blake2b(hashes.encode(), digest_size=16).hexdigest()

    def to_plain(self) -> dict[str, Any]:
        """The results as plain data: of the run, and of each vehicle."""
        first = self.vehicles[0].to_plain()
        of_run = ("scene", "seed", "sim_seconds", "wall_seconds", "cpu_seconds")
        return {
            "success": self.success,
            "reason": self.reason,
            **{name: first[name] for name in (*of_run, "real_time_factor", "recording")},
            "state_hash": self.state_hash,
            "vehicles": [
                {"system": self.first_system + i, **result.to_plain()}
                for i, result in enumerate(self.vehicles)
            ],
        }


class SharedSitl:
    """One run of several vehicles; see `Sitl`, of which each has one.

    Attributes:
        bench: The simulated world with all vehicles and their autopilots.
        flights: Run of each vehicle; `run` is called here.
    """

    def __init__(
        self,
        cfg: SitlCfg,
        *,
        scene: Scene | None = None,
        has_network: bool = True,
        links: Sequence[Sequence[Link]] = (),
    ) -> None:
        """Open every part of the run, or none.

        Args:
            cfg: Configuration of the run; an assigned area is the first vehicle's.
            scene: Scene to fly in, instead of the one that the configuration names.
            has_network: Whether clients outside this process can connect.
            links: MAVLink links of one's own besides, for each vehicle.

        Raises:
            INPUT_ERRORS: If the run cannot be opened; one line says why, and what would be valid.
        """
        self.cfg = cfg = cfg if scene is None else replace(cfg, scene=scene.scene_id)
        with ExitStack() as stack:
            hangar = stack.enter_context(Hangar())
            airframes = cfg.airframes
            scene = scene or hangar.scene(cfg.scene)
            if cfg.start is not None:
                scene = with_start(scene, airframes[0], cfg.start)
            name = cfg.area
            area = None if name is None else find_area(scene, airframes[0], name, "area")
            self.bench = stack.enter_context(
                SharedTestbench(
                    scene,
                    cfg.bench,
                    airframes,
                    has_network=has_network,
                    links=links,
                    captures=cfg.captures,
                    has_video=cfg.video,
                )
            )
            benches = self.bench.benches
            if cfg.pictures is not None:
                cfg.pictures.mkdir(exist_ok=True)
            missions = plan_missions(cfg, benches, area) if cfg.demo else [None] * len(benches)
            self.flights = tuple(
                stack.enter_context(
                    Sitl(
                        _cfg_of(cfg, i, bench.cfg.instance),
                        hangar=hangar,
                        among=Among(bench=bench, mission=missions[i], mates=bench.plant.mates),
                    )
                )
                for i, bench in enumerate(benches)
            )
            if (recorder := self.flights[0].recorder) is not None:
                for flight, part in zip(self.flights[1:], recorder.mates.values(), strict=True):
                    flight.join(part)
            for flight in self.flights:
                flight.log.fly_with([mate.log for mate in self.flights if mate is not flight])
            self._stack = stack.pop_all()

    @property
    def viewer(self) -> Viewer | None:
        """Viewer that shows the run live, if it is watched."""
        return self.flights[0].viewer

    @property
    def pictures(self) -> list[Path]:
        """Files that were drawn when the run ended."""
        return [path for flight in self.flights for path in flight.pictures]

    @property
    def missing(self) -> list[str]:
        """A line for each file that was asked for and could not be written whole."""
        return [line for flight in self.flights for line in flight.missing]

    def run(self, should_stop: Callable[[], bool | str] = lambda: False) -> SharedResult:
        """Simulate until every vehicle's run is over, judge each, and write what was asked for.

        Args:
            should_stop: Called every tick; the run ends when this is true or says by what.
        """
        clock = RunClock()
        stopped_by = run_until_over(
            self.bench.simulator,
            [flight.schedule() for flight in self.flights],
            lambda: should_stop() or self.bench.fault,
        )
        results = tuple(flight.conclude(stopped_by, clock) for flight in self.flights)
        # The first one's run closes the recording.
        for flight, result in zip(self.flights[:0:-1], results[:0:-1], strict=True):
            flight.write(result)
        self.flights[0].write(results[0], results[1:])
        results = (self.flights[0].offered(results[0]), *results[1:])
        return SharedResult(first_system=1 + self.cfg.bench.instance, vehicles=results)

    def close(self) -> None:
        """Finish the recording, end the viewer, give the ports back."""
        self._stack.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()


def _cfg_of(cfg: SitlCfg, number: int, instance: int) -> SitlCfg:
    """Configuration of one vehicle; there is one recording, which the first one's run opens."""
    cfg = replace(cfg, vehicles="", bench=replace(cfg.bench, instance=instance))
    if number == 0:
        return cfg
    pictures = None if cfg.pictures is None else cfg.pictures / vehicle_name(number)
    return replace(cfg, area=None, record=None, viewer="off", pictures=pictures)
