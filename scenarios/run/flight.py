"""One vehicle's part of a run: its pilot, its log, its pictures, and its verdict.

A run may have several vehicles, and each is judged by itself. This class holds everything that
belongs to one of them, so that one vehicle is the case of one.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from aeroscene.scene import InteractionArea
from flightsim.cameras import Cameras
from flightsim.mavlink.client import MavlinkClient
from flightsim.testbench import Testbench, Vehicle
from scenarios.run.cfg import SitlCfg
from scenarios.run.goal_announcement import announce_goal
from scenarios.run.hangar import Hangar
from scenarios.run.missions import new_pilot, plan_missions, plan_to_words
from scenarios.run.schedule import Schedule
from scenarios.trials.figures import Goal
from scenarios.trials.flight_log import FlightLog
from scenarios.trials.result import TrialResult, figures, rounded
from scenarios.trials.score import FlightScore
from scenarios.trials.verdict import Code, Ending, Judgement, judge
from scenarios.trials.word_scores import nearest_area, score_words

if TYPE_CHECKING:
    from scenarios.mission.mission import Mission
    from scenarios.pictures.tape import FlightTape
    from scenarios.pilot import Pilot
    from scenarios.run.companion import Aboard, Companion
    from scenarios.words.goal_drawing import WordGoal


class Flight:
    """A vehicle's part of a run, from its start to its verdict.

    Attributes:
        vehicle: The vehicle with its stack.
        words: Goal in words; None if it is an area.
        area: Area that was assigned by its number; None leaves it to the draw, or to the companion.
        log: Rows that score and hash need.
        pilot: Our own pilot, in a demo.
        companion: Pilot that flies, our own or the caller's; None in a run for clients alone.
    """

    def __init__(
        self,
        cfg: SitlCfg,
        bench: Testbench,
        vehicle: Vehicle,
        hangar: Hangar,
        stack: ExitStack,
        *,
        area: InteractionArea | None,
        mission: Mission | None,
        pilot: Callable[[Aboard], Companion] | None,
        words: WordGoal | None = None,
    ) -> None:
        """Follow a vehicle from now on.

        Args:
            cfg: Configuration of the run.
            bench: Testbench whose ticks are followed.
            vehicle: The vehicle.
            hangar: Resources that runs of this process share.
            stack: Closes everything that the flight opens, now or later.
            area: Assigned area.
            mission: Mission for our own pilot, in a demo.
            pilot: Makes the caller's pilot.
            words: Goal in words; landing on any of its areas is a success.
        """
        self.vehicle, self.area, self.words = vehicle, area, words
        if words is not None:
            announce_goal(bench, vehicle, words.text)
        self._cfg, self._hangar, self._stack = cfg, hangar, stack
        self._cameras: Cameras | None = None
        self.log = FlightLog(vehicle.plant, is_judged=cfg.demo or pilot is not None)
        # Observers run in this order: the log records a tick before the pilot reacts to it.
        bench.observers.append(self.log.on_tick)
        self.pilot: Pilot | None = None
        if mission is not None:
            self.pilot = new_pilot(vehicle, mission, self.cameras.render_depth)
        self.companion = self.pilot if pilot is None else pilot(self._aboard(pilot))
        if (companion := self.companion) is not None:
            bench.observers.append(lambda: companion.update(vehicle.plant.time_us))
        self._tape = None if cfg.pictures is None else self._open_tape()
        if self._tape is not None:
            bench.observers.append(self._tape.on_tick)

    @property
    def cameras(self) -> Cameras:
        """The vehicle's cameras, opened on first use, because a renderer takes time and memory."""
        if self._cameras is None:
            self._cameras = self._stack.enter_context(self._hangar.cameras(self.vehicle))
        return self._cameras

    def _aboard(self, pilot: Callable[[Aboard], Companion]) -> Aboard:
        from scenarios.run.companion import Aboard, Insight

        vehicle, words, scene = self.vehicle, self.words, self.vehicle.scene
        # Only makers that declare themselves as baselines of perfect perception get it.
        insight = None
        if words is not None and getattr(pilot, "has_insight", False):
            insight = Insight(scene=scene, description=words.description)
        # The scene would give the goal away to a pilot that is not given the map.
        if words is not None and self._cfg.map == "onboard":
            scene = replace(scene, objects=(), interaction_areas=(), relief=None)
        return Aboard(
            client=vehicle.connect(),
            link=vehicle.stack.pipe(),
            # Opens the cameras only if the pilot looks.
            render=lambda camera: self.cameras.render(camera),  # noqa: PLW0108
            scene=scene,
            airframe=vehicle.airframe,
            area=self.area,
            text="" if words is None else words.text,
            insight=insight,
            scan=lambda: None if vehicle.lidar is None else vehicle.lidar.latest,
            our_pilot=self._our_pilot,
            plant=vehicle.plant if getattr(pilot, "sees_plant", False) else None,
        )

    def _our_pilot(self, client: MavlinkClient) -> Pilot:
        """Plan the flight, and return our own pilot for it, which steers by a given client.

        Raises:
            TestbenchError: If there is no plan.
        """
        if self.words is not None:
            mission = plan_to_words(self._cfg, self.vehicle, self.words)
        else:
            (mission,) = plan_missions(self._cfg, [self.vehicle], self.area)
        return new_pilot(self.vehicle, mission, self.cameras.render_depth, client)

    def _open_tape(self) -> FlightTape:
        from scenarios.pictures.tape import FlightTape

        plant = self.vehicle.plant
        return FlightTape(plant, self.vehicle.stack.reports, self.pilot, plant.other_plants)

    def schedule(self) -> Schedule:
        """Return the schedule of the rest of the flight, from now on."""
        longest_s = self._cfg.headless_seconds
        is_to_land = self.words is not None
        return Schedule(
            self.vehicle.plant, self.log, self.companion, longest_s, is_to_land=is_to_land
        )

    def conclude(
        self, stopped_by: str | None, spent_s: tuple[float, float], recording: str | None
    ) -> TrialResult:
        """Judge the flight.

        Args:
            stopped_by: Cause that ended the run early, if any.
            spent_s: Wall time and CPU time of the run.
            recording: File that the result names.
        """
        goal = self._goal()
        score = self.log.score(goal)
        measured = figures(score, None if goal is None else goal.area, self.companion)
        if self.words is not None and goal is not None:
            found = score_words(self.log.positions_enu_m(), self.words.areas)
            measured |= {name: rounded(figure) for name, figure in asdict(found).items()}
        judgement = self._judge(score, goal, stopped_by)
        return self._result(measured, judgement, spent_s, recording)

    def draw(self, ending: str, folder: Path) -> list[Path]:
        """Draw the contents of the tape into a folder.

        Args:
            ending: End of the flight in words, for the caption.
            folder: Folder of the pictures.

        Returns:
            The files; none if there is no tape.

        Raises:
            PictureError: If it cannot be written.
        """
        if self._tape is None or not self._tape.has_any:
            return []
        from scenarios.pictures import draw_pictures

        return draw_pictures(self._tape.story(ending), folder, self._cfg.formats)

    def _goal(self) -> Goal | None:
        """Return the goal by which the flight is judged; None if nobody flew."""
        if self.companion is None:
            return None
        area = self.area or self.companion.area
        if self.words is not None:
            # Landing on any area of the place counts: the flight is judged by the one on which it
            # ended.
            area = nearest_area(self.log.positions_enu_m()[-1], self.words.areas)
        elif self.pilot is not None:
            area = self.pilot.mission.area
        return Goal(
            area=area,
            chosen_enu_m=getattr(self.companion, "touchdown_enu_m", None),
            others=self.vehicle.scene.interaction_areas,
            navigation_limit_s=self._cfg.navigation_limit_s,
        )

    def _judge(self, score: FlightScore, goal: Goal | None, stopped_by: str | None) -> Judgement:
        companion = self.companion
        if companion is None or goal is None:
            reason = "ended" if stopped_by is None else f"ended by {stopped_by}"
            return Judgement(code=Code.ENDED, reason=reason)
        ending = Ending(word=companion.verdict, is_done=companion.is_done, stopped_by=stopped_by)
        return judge(score, goal, ending)

    def _result(
        self,
        measured: dict[str, Any],
        judgement: Judgement,
        spent_s: tuple[float, float],
        recording: str | None,
    ) -> TrialResult:
        vehicle, (wall_s, cpu_s) = self.vehicle, spent_s
        sim_s, external = vehicle.plant.time_us * 1e-6, vehicle.external
        x, y, z = (round(c, 3) for c in vehicle.scene.start_position_enu_m)
        return TrialResult(
            success=judgement.success,
            reason=judgement.reason,
            code=judgement.code,
            fate=judgement.fate,
            scene=vehicle.scene.scene_id,
            vehicle=vehicle.airframe.name,
            seed=vehicle.cfg.seed,
            start=(x, y, z),
            goal="area" if self.words is None else self.words.grade,
            text=None if self.words is None else self.words.text,
            sim_seconds=round(sim_s, 2),
            wall_seconds=round(wall_s, 2),
            cpu_seconds=round(cpu_s, 2),
            real_time_factor=round(sim_s / wall_s, 2),
            state_hash=self.log.state_hash(),
            recording=recording,
            lockstep=None if external is None else asdict(external.exchanges),
            **measured,
        )
