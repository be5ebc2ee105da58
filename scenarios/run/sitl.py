"""One run of the testbench: simulate, let pilots fly if there are any, and judge the flights.

Everything that `aeroscene sitl`, `fly` and a campaign's trial have in common is here: one object
that opens world, pilots and recorder, runs the loop, and writes the result. Libraries that only
some runs need are imported when they are needed.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Self

from aeroscene.scene import InteractionArea, Scene
from flightsim.environment.movers import MovingObstacle
from flightsim.mavlink.links import Link
from flightsim.testbench import Testbench
from flightsim.vehicles import Airframe
from flightsim.vehicles.builder import vehicle_name
from scenarios.mission.goals import find_area, with_start
from scenarios.run.cfg import SitlCfg
from scenarios.run.flight import Flight
from scenarios.run.hangar import Hangar
from scenarios.run.missions import plan_missions, plan_to_words
from scenarios.run.results import RunResult
from scenarios.run.schedule import RunClock, run_until_over
from scenarios.run.summary import write_summary
from scenarios.trials.result import TrialResult

if TYPE_CHECKING:
    from scenarios.airsim.settings import AirsimSettings
    from scenarios.mission.mission import Mission
    from scenarios.pilot import Pilot
    from scenarios.recording import Recorder
    from scenarios.recording.viewer import Viewer
    from scenarios.run.companion import Aboard, Companion
    from scenarios.words.goal_drawing import WordGoal

_LOG = logging.getLogger(__name__)


class Sitl:
    """One run of the testbench: opens its parts, runs it, judges it and closes it.

    Attributes:
        bench: The simulated world with its vehicles and their autopilots.
        flights: Flight of each vehicle, with its pilot, its log and its cameras.
        words: Goal in words of the flight; None if it is an area.
        recorder: Recorder of the run, if it is recorded or watched.
        viewer: Viewer that shows the run live, if it is watched.
        result: Results of all vehicles, once `run` has ended.
        pictures: Files that were drawn when the run ended.
        missing: A line for each requested file that could not be written whole.
        airsim_port: Port on which AirSim's clients are answered; None without --airsim.
    """

    def __init__(
        self,
        cfg: SitlCfg,
        *,
        scene: Scene | None = None,
        airframes: Sequence[Airframe] = (),
        pilot: Callable[[Aboard], Companion] | None = None,
        has_network: bool = True,
        links: Sequence[Sequence[Link]] = (),
        hangar: Hangar | None = None,
        movers: Sequence[MovingObstacle] | None = None,
    ) -> None:
        """Open every part of the run, or none.

        Args:
            cfg: Configuration of the run; an assigned area is the first vehicle's.
            scene: Scene to fly in, instead of the one that the configuration names.
            airframes: Vehicles of your own, instead of those that the configuration names.
            pilot: Makes a pilot of your own for each vehicle, which flies instead of ours.
            has_network: True if clients outside this process can connect.
            links: Further MAVLink links of your own, for the first vehicle, the second and so on.
            hangar: Resources that runs of this process share; None keeps them for this run alone.
            movers: Traffic on paths of your own instead of the configured one.

        Raises:
            INPUT_ERRORS: If the run cannot be opened; one line says why, and what would be valid.
        """
        airsim: AirsimSettings | None = None
        if cfg.airsim_settings is not None:
            from scenarios.run.airsim import with_settings

            cfg, airsim = with_settings(cfg, cfg.airsim_settings)
        self.cfg = cfg = cfg if scene is None else replace(cfg, scene=scene.scene_id)
        self.recorder: Recorder | None = None
        self.viewer: Viewer | None = None
        self.result: RunResult | None = None
        self.pictures: list[Path] = []
        self.missing: list[str] = []
        self.airsim_port: int | None = None
        self._stack = stack = ExitStack()
        # If any part fails to open, those opened before are closed again.
        with ExitStack() as opening:
            opening.push(stack)
            hangar = stack.enter_context(Hangar()) if hangar is None else hangar
            scene, airframes = scene or hangar.scene(cfg.scene), airframes or cfg.airframes
            if airsim is not None:
                scene = airsim.located(scene)
            if cfg.start is not None:
                scene = with_start(scene, airframes[0], cfg.start)
            name = cfg.area
            area = None if name is None else find_area(scene, airframes[0], name, "area")
            self.words = self._words(scene, airframes[0], area)
            self.bench = stack.enter_context(
                Testbench(
                    scene,
                    cfg.bench,
                    airframes=airframes,
                    traffic=movers,
                    has_network=has_network,
                    links=links,
                    captures=cfg.captures,
                    has_video=cfg.video,
                )
            )
            self.flights = self._open_flights(hangar, area, pilot)
            if cfg.record is not None or cfg.viewer != "off":
                from scenarios.run.observation import watch

                self.recorder, self.viewer = watch(cfg, self.bench, self.flights, stack)
            if cfg.ros2:
                from scenarios.run.ros2 import open_door

                open_door(cfg, self.bench, self.flights, stack)
            if cfg.airsim:
                from scenarios.run.airsim import open_airsim

                door = open_airsim(cfg, airsim, self.bench, self.flights, stack)
                self.airsim_port = door.port
            opening.pop_all()

    def _open_flights(
        self,
        hangar: Hangar,
        area: InteractionArea | None,
        pilot: Callable[[Aboard], Companion] | None,
    ) -> tuple[Flight, ...]:
        """Open the flight of each vehicle; an assigned area is the first one's."""
        cfg, vehicles = self.cfg, self.bench.vehicles
        is_ours = cfg.demo and pilot is None
        missions: Sequence[Mission | None] = [None] * len(vehicles)
        if is_ours and self.words is not None:
            missions = [plan_to_words(cfg, vehicles[0], self.words)]
        elif is_ours:
            missions = plan_missions(cfg, vehicles, area)
        flights: list[Flight] = []
        for vehicle, mission in zip(vehicles, missions, strict=True):
            # With a goal in words the pilot must not learn the area, and other vehicles have none
            # assigned.
            own_area = None if flights or self.words is not None else area
            flights.append(
                Flight(
                    cfg,
                    self.bench,
                    vehicle,
                    hangar,
                    self._stack,
                    area=own_area,
                    mission=mission,
                    pilot=pilot,
                    words=self.words,
                )
            )
        for flight in flights:
            # After all flights are open: each log needs those of all others.
            flight.log.fly_with([mate.log for mate in flights if mate is not flight])
        return tuple(flights)

    def _words(
        self, scene: Scene, airframe: Airframe, area: InteractionArea | None
    ) -> WordGoal | None:
        """Return the goal in words, if the run has one.

        Raises:
            WordsError: If no text fits one place alone.
        """
        cfg = self.cfg
        if cfg.goal == "area":
            return None
        from scenarios.words.goal_choice import choose_goal

        return choose_goal(scene, airframe, asked=cfg.goal, seed=cfg.bench.seed, area=area)

    @property
    def pilot(self) -> Pilot | None:
        """Our own pilot of the first vehicle, in a demo."""
        return self.flights[0].pilot

    def run(self, should_stop: Callable[[], bool | str] = lambda: False) -> TrialResult:
        """Simulate, judge the flights, and write the verdict into and beside the recording.

        Args:
            should_stop: Called every tick. The run ends when every flight is over, the time is up,
                or this returns True or the cause that stops the run, such as SIGTERM.

        Returns:
            The verdict and the figures of the first vehicle; `result` has those of all. Without a
            pilot there is no verdict.
        """
        clock = RunClock()
        stopped_by = run_until_over(
            self.bench.simulator,
            [flight.schedule() for flight in self.flights],
            # A fault of an external flight stack ends the run like a signal.
            lambda: should_stop() or self.bench.fault,
        )
        spent_s = clock.spent_s()
        names = [None if self.cfg.record is None else str(self.cfg.record)]
        # One recording holds all vehicles; it is listed with the first.
        names += [None] * len(self.bench.plant.other_plants)
        first, *mates = (
            flight.conclude(stopped_by, spent_s, name)
            for flight, name in zip(self.flights, names, strict=True)
        )
        self._write(first, mates)
        if self.recorder is not None and self.recorder.fault is not None:
            first = replace(first, recording=None)  # It lacked its end and is removed.
        self.result = RunResult(first_system=1 + self.cfg.bench.instance, vehicles=(first, *mates))
        return first

    def _write(self, first: TrialResult, mates: Sequence[TrialResult]) -> None:
        """Write all files; one that cannot be written costs neither the verdict nor the others."""
        if self.recorder is not None:
            # The recording first, then the summary beside it, then the pictures.
            self.recorder.conclude(first.to_plain(), [mate.to_plain() for mate in mates])
            if (fault := self.recorder.fault) is not None:
                self.recorder.discard()
                self._miss(f"recording {self.recorder.path} lacks its end and is removed: {fault}")
        path, cfg = self.cfg.record, self.cfg
        if path is not None and (fault := write_summary(path, cfg, first, self.pilot, mates)):
            self._miss(fault)
        if cfg.pictures is not None:
            self._draw(cfg.pictures, (first, *mates))

    def _draw(self, folder: Path, results: Sequence[TrialResult]) -> None:
        """Draw the flight of the first vehicle into a folder, those of its mates below it."""
        from scenarios.pictures import PictureError

        for number, (flight, result) in enumerate(zip(self.flights, results, strict=True)):
            own = folder / vehicle_name(number) if number else folder
            try:
                self.pictures += flight.draw(result.reason, own)
            except PictureError as error:
                self._miss(str(error))

    def _miss(self, line: str) -> None:
        self.missing.append(line)
        _LOG.warning("%s", line)

    def close(self) -> None:
        """Finish the recording, end the viewer, release the ports."""
        self._stack.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()
