"""One run of the testbench: simulate, let a pilot fly if there is one, and judge the flight."""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

from aeroscene.scene import Scene
from flightsim.cameras import Cameras
from flightsim.environment.movers import MovingObstacle
from flightsim.mavlink.links import Link
from flightsim.plant import Plant
from flightsim.testbench import Testbench
from flightsim.vehicles import Airframe, airframe_by_name
from scenarios.mission.goals import find_area, with_start
from scenarios.run.among import Among
from scenarios.run.cfg import SitlCfg
from scenarios.run.hangar import Hangar
from scenarios.run.missions import new_pilot, plan_missions
from scenarios.run.schedule import RunClock, Schedule, run_until_over
from scenarios.run.summary import write_summary
from scenarios.trials.flight_log import FlightLog
from scenarios.trials.result import TrialResult, figures
from scenarios.trials.score import FlightScore, Goal
from scenarios.trials.verdict import Code, Ending, Judgement, judge

if TYPE_CHECKING:
    from scenarios.pictures.tape import FlightTape
    from scenarios.pilot import Pilot
    from scenarios.recording import Recorder
    from scenarios.recording.vehicle_recorder import VehicleRecorder
    from scenarios.recording.viewer import Viewer
    from scenarios.run.companion import Aboard, Companion

_LOG = logging.getLogger(__name__)


class Sitl:
    """One run of the testbench: opens its parts, runs it, judges it and closes it.

    Attributes:
        area: Area that was assigned by its number; None leaves it to the draw, or to the companion.
        bench: The simulated world and its autopilot.
        pilot: Our own pilot, in a demo.
        companion: Pilot that flies, our own or the caller's; None in a run for clients alone.
        recorder: Recorder of the run, if it is recorded or watched.
        viewer: Viewer that shows the run live, if it is watched.
        pictures: Files that were drawn when the run ended.
        missing: A line for each file that was asked for and could not be written whole.
    """

    def __init__(
        self,
        cfg: SitlCfg,
        *,
        scene: Scene | None = None,
        airframe: Airframe | None = None,
        pilot: Callable[[Aboard], Companion] | None = None,
        has_network: bool = True,
        links: Sequence[Link] = (),
        hangar: Hangar | None = None,
        movers: Sequence[MovingObstacle] | None = None,
        among: Among | None = None,
    ) -> None:
        """Open every part of the run, or none.

        Args:
            cfg: Configuration of the run.
            scene: Scene to fly in, instead of the one that the configuration names.
            airframe: A vehicle of one's own, instead of the one that the configuration names.
            pilot: Makes a pilot of one's own, which flies instead of ours.
            has_network: Whether clients outside this process can connect.
            links: MAVLink links of one's own besides.
            hangar: Keeps what runs of this process share; None keeps it for this run alone.
            movers: Traffic on paths of one's own instead of the configured one.
            among: One of several vehicles, which `SharedSitl` opens and runs; None for one alone.

        Raises:
            INPUT_ERRORS: If the run cannot be opened; one line says why, and what would be valid.
        """
        self.cfg = cfg if scene is None else replace(cfg, scene=scene.scene_id)
        self.recorder: Recorder | None = None
        self._part: VehicleRecorder | None = None
        self.viewer: Viewer | None = None
        self.pictures: list[Path] = []
        self.missing: list[str] = []
        self._cameras: Cameras | None = None
        with ExitStack() as stack:
            self._stack = stack
            self._hangar = stack.enter_context(Hangar()) if hangar is None else hangar
            if among is None:
                bench = stack.enter_context(
                    self._open_bench(scene, airframe, has_network, links, movers)
                )
            else:
                bench = among.bench
            self.bench = bench
            name = cfg.area
            self.area = (
                None if name is None else find_area(bench.scene, bench.airframe, name, "area")
            )
            self.log = FlightLog(bench.plant, is_judged=cfg.demo or pilot is not None)
            bench.observers.append(self.log.on_tick)
            self.pilot: Pilot | None = None
            if cfg.demo and pilot is None:
                mission = among.mission if among is not None else None
                mission = mission or plan_missions(cfg, [bench], self.area)[0]
                self.pilot = new_pilot(bench, mission, self.cameras.render_depth)
            self.companion = self.pilot if pilot is None else pilot(self._aboard())
            if (companion := self.companion) is not None:
                self.bench.observers.append(lambda: companion.update(bench.plant.time_us))
            if cfg.record is not None or cfg.viewer != "off":
                from scenarios.run.watching import watch

                self.recorder, self.viewer = watch(self, stack)
            mates = () if among is None else among.mates
            self._tape = None if cfg.pictures is None else self._open_tape(mates)
            self._stack = stack.pop_all()

    def _open_bench(
        self,
        scene: Scene | None,
        airframe: Airframe | None,
        has_network: bool,
        links: Sequence[Link],
        movers: Sequence[MovingObstacle] | None,
    ) -> Testbench:
        cfg = self.cfg
        airframe = airframe or airframe_by_name(cfg.bench.vehicle)
        scene = scene or self._hangar.scene(cfg.scene)
        if cfg.start is not None:
            scene = with_start(scene, airframe, cfg.start)
        return Testbench(
            scene,
            cfg.bench,
            airframe=airframe,
            traffic=movers,
            has_network=has_network,
            extra_links=links,
            captures=cfg.captures,
            has_video=cfg.video,
        )

    @property
    def cameras(self) -> Cameras:
        """The vehicle's cameras, opened when first asked for."""
        if self._cameras is None:
            self._cameras = self._stack.enter_context(self._hangar.cameras(self.bench))
        return self._cameras

    def _aboard(self) -> Aboard:
        from scenarios.run.companion import Aboard

        bench = self.bench
        return Aboard(
            client=bench.connect(),
            link=bench.stack.pipe(),
            # Opens the cameras only where somebody looks.
            render=lambda camera: self.cameras.render(camera),  # noqa: PLW0108
            scene=bench.scene,
            airframe=bench.airframe,
            area=self.area,
            scan=lambda: None if bench.lidar is None else bench.lidar.latest,
        )

    def _open_tape(self, mates: Sequence[Plant]) -> FlightTape:
        from scenarios.pictures.tape import FlightTape

        tape = FlightTape(self.bench.plant, self.bench.stack.reports, self.pilot, mates)
        self.bench.observers.append(tape.on_tick)
        return tape

    def _draw(self, ending: str) -> list[Path]:
        """Draw what the tape holds."""
        if self._tape is None or self.cfg.pictures is None or not self._tape.has_any:
            return []
        from scenarios.pictures import PictureError, draw_pictures

        try:
            return draw_pictures(self._tape.story(ending), self.cfg.pictures, self.cfg.formats)
        except PictureError as error:
            self._miss(str(error))
            return []

    def run(self, should_stop: Callable[[], bool | str] = lambda: False) -> TrialResult:
        """Simulate, judge what was flown, and write the verdict into and beside the recording.

        Args:
            should_stop: Called every tick; the run ends when the demo is done, the time is up, or
                this is true or says by what the run is stopped, such as SIGTERM.

        Returns:
            The verdict and the figures; without a pilot there is no verdict.
        """
        clock = RunClock()
        stopped_by = run_until_over(
            self.bench.simulator, [self.schedule()], lambda: should_stop() or self.bench.stack.fault
        )
        result = self.conclude(stopped_by, clock)
        self.write(result)
        return self.offered(result)

    def offered(self, result: TrialResult) -> TrialResult:
        """The result without a recording that lacked its end and was removed."""
        is_torn = self.recorder is not None and self.recorder.fault is not None
        return replace(result, recording=None) if is_torn else result

    def schedule(self) -> Schedule:
        """What of the run is still to come, from now on."""
        return Schedule(self.bench.plant, self.log, self.companion, self.cfg.headless_seconds)

    def conclude(self, stopped_by: str | None, clock: RunClock) -> TrialResult:
        """Judge what was flown; `stopped_by` is what ended it before its end, if anything did."""
        wall_s, cpu_s = clock.spent_s()
        goal = self._goal()
        score = self.log.score(goal)
        measured = figures(score, None if goal is None else goal.area, self.companion)
        return self._result(measured, self._judge(score, goal, stopped_by), wall_s, cpu_s)

    def join(self, part: VehicleRecorder) -> None:
        """Record into the recording that another vehicle's run has opened."""
        from scenarios.run.watching import follow

        self._part = part
        follow(self, part)

    def write(self, result: TrialResult, mates: Sequence[TrialResult] = ()) -> None:
        """Write all files; one that cannot be written costs neither the verdict nor the others.

        Args:
            result: Verdict and figures.
            mates: Those of the other vehicles in the same recording.
        """
        if self._part is not None:
            self._part.conclude(result.to_plain())
            self._part.log_verdict(result.to_plain())
        if self.recorder is not None:
            self.recorder.conclude(result.to_plain())
            if (fault := self.recorder.fault) is not None:
                self.recorder.discard()
                self._miss(f"recording {self.recorder.path} lacks its end and is removed: {fault}")
        path, cfg = self.cfg.record, self.cfg
        if path is not None and (fault := write_summary(path, cfg, result, self.pilot, mates)):
            self._miss(fault)
        self.pictures = self._draw(result.reason)

    def _miss(self, line: str) -> None:
        self.missing.append(line)
        _LOG.warning("%s", line)

    def _goal(self) -> Goal | None:
        """Where the flight should have ended; None if nobody flew."""
        if self.companion is None:
            return None
        area = self.area or self.companion.area
        if self.pilot is not None:
            area = self.pilot.mission.area
        return Goal(
            area=area,
            chosen_enu_m=getattr(self.companion, "touchdown_enu_m", None),
            others=self.bench.scene.interaction_areas,
        )

    def _judge(self, score: FlightScore, goal: Goal | None, stopped_by: str | None) -> Judgement:
        companion = self.companion
        if companion is None or goal is None:
            reason = "ended" if stopped_by is None else f"ended by {stopped_by}"
            return Judgement(code=Code.ENDED, reason=reason)
        ending = Ending(word=companion.verdict, is_done=companion.is_done, stopped_by=stopped_by)
        return judge(score, goal, ending)

    def _result(
        self, measured: dict[str, Any], judgement: Judgement, wall_s: float, cpu_s: float
    ) -> TrialResult:
        bench = self.bench
        sim_s, external = bench.plant.time_us * 1e-6, bench.external
        x, y, z = (round(c, 3) for c in bench.scene.start_position_enu_m)
        return TrialResult(
            success=judgement.success,
            reason=judgement.reason,
            code=judgement.code,
            fate=judgement.fate,
            scene=bench.scene.scene_id,
            vehicle=bench.airframe.name,
            seed=self.cfg.bench.seed,
            start=(x, y, z),
            sim_seconds=round(sim_s, 2),
            wall_seconds=round(wall_s, 2),
            cpu_seconds=round(cpu_s, 2),
            real_time_factor=round(sim_s / wall_s, 2),
            state_hash=self.log.state_hash(),
            recording=None if self.cfg.record is None else str(self.cfg.record),
            lockstep=external and asdict(external.exchanges),
            **measured,
        )

    def close(self) -> None:
        """Finish the recording, end the viewer, give the ports back."""
        self._stack.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()
