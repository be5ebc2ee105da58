"""Flies trials one after another in one process, which stays warm between them.

Starting a process, opening a scene and compiling kernels take many times as long as a flight.
Scene, distance field, renderer, kernels and the planner's programs are therefore kept, and no
network link is opened. A trial is the same, bit for bit, in a warm process and in a fresh one.
"""

from __future__ import annotations

import logging
import math
import time
from collections import OrderedDict
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from enum import StrEnum
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple, Self

import numpy as np

from aeroscene import __version__
from aeroscene.solids import field_cache
from flightsim.environment.traffic import TrafficError
from flightsim.vehicles import airframe_by_name
from flightsim.world import WorldError
from scenarios.baselines.named import (
    OURS,
    POLICY,
    READERS,
    SHIPPED,
    NamedPilot,
    PilotError,
    pilot_of,
)
from scenarios.campaigns.equipment import Equipment
from scenarios.campaigns.external.flight import ExternalFlights
from scenarios.campaigns.external.pilot import CrashedError, SilentError
from scenarios.campaigns.external.program import words_of
from scenarios.campaigns.external.user_class import PilotFaultError, UserPilot
from scenarios.campaigns.flight_stack import FlightStack
from scenarios.campaigns.recordings import Recordings
from scenarios.chat.completions import ChatError, ChatModel
from scenarios.mission.surroundings import MissionError
from scenarios.run.hangar import Hangar
from scenarios.run.input_errors import INPUT_ERRORS
from scenarios.run.sitl import Sitl
from scenarios.tasks.reach import NoTaskError
from scenarios.tasks.recipe import Recipe
from scenarios.tasks.sampler import Sampler
from scenarios.tasks.task import Task, trial_id
from scenarios.trials.grade import grade, progress
from scenarios.trials.measures.track import track_of
from scenarios.trials.result import TrialResult
from scenarios.trials.word_scores import spl

_LOG = logging.getLogger(__name__)

Row = dict[str, Any]
"""A trial as a row of the results: its task, its verdict, its figures."""
EXTERNAL = "mavlink"
"""Name of a pilot outside this process."""
_KEPT_SAMPLERS = 2  # two vehicles of a scene by turns


class NoFlightCode(StrEnum):
    """Code of a trial that had no flight to judge; codes of flights are `Code`s."""

    NO_TASK = "no_task"
    """The scene has no task for the vehicle: neither a success nor a failure."""
    NO_PLAN = "no_plan"
    """The pilot found no path, and did not begin."""
    RAISED = "raised"
    """The pilot raised an error."""
    HUNG = "hung"
    """The pilot gave no answer and its process was ended, or the flight stack was lost."""
    DIED = "died"
    """The process ended, and did so again when the trial was repeated."""


class Trial(NamedTuple):
    """Name of a trial in its parts."""

    scene: str
    vehicle: str
    number: int
    family: str = ""
    """Family whose recipe it is drawn from; empty for the recipe of the campaign."""

    @property
    def id(self) -> str:
        """The name as one word, unique within a campaign."""
        return trial_id(*self)


@dataclass(frozen=True, kw_only=True)
class Suite:
    """Everything that decides the outcome of a trial besides its name and the code.

    It also has the recordings to keep, which decide no outcome.
    """

    recipe: Recipe = field(default_factory=Recipe)
    """Recipe of a trial's task, unless the trial is of a family."""
    families: Mapping[str, Recipe] = field(default_factory=dict)
    """Recipe of each family's tasks."""
    pilot: str = OURS
    """The pilot: one of those that ship, MODULE:CLASS, or mavlink for a pilot outside this process.
    """
    program: str | None = None
    """Command that flies each trial over MAVLink; None waits for a client."""
    chat: ChatModel | None = None
    """Model that steers the pilot `vlm`."""
    stack: FlightStack | None = None
    """Flight stack that the pilot commands; None is our autopilot."""
    equipment: Equipment = field(default_factory=Equipment)
    """Cameras and sensors of the vehicles."""
    recordings: Recordings | None = field(default=None, compare=False)
    """Recordings to keep; None records nothing. They decide no outcome."""

    def recipe_of(self, family: str) -> Recipe:
        """Return the recipe of a family; for an empty name, the campaign's recipe.

        Raises:
            NoTaskError: If the suite has no such family.
        """
        if family and family not in self.families:
            raise NoTaskError(
                f"family {family!r} is none of this campaign; valid: "
                f"{', '.join(self.families) or 'none'}"
            )
        return self.families[family] if family else self.recipe

    @property
    def is_external(self) -> bool:
        """True if the pilot is outside this process."""
        return self.pilot == EXTERNAL

    @property
    def foreign_code(self) -> dict[str, str]:
        """Modules and programs that a flight runs besides what ships, by the option's name.

        A folder of results may come from anybody. These names must be given again on the command
        line before a trial of it is flown.
        """
        found: dict[str, str] = {}
        if not self.is_external and self.pilot not in SHIPPED:
            found["pilot"] = self.pilot
        if self.is_external and self.program is not None:
            found["program"] = self.program
        if self.chat is not None:
            # Images and, over https, the user's key would be sent there.
            found["endpoint"] = self.chat.endpoint
        if self.stack is not None:
            found["autopilot-binary"] = self.stack.binary
        return found

    def require_pilot(self) -> None:
        """Refuse a suite that cannot be flown.

        Raises:
            PilotError: If its pilot is not there.
            ProgramError: If its program is not there.
            FlightStackError: If its flight stack is not there.
        """
        if self.stack is not None:
            self.stack.require()
        recipes = self.families.values() or [self.recipe]
        if self.pilot in READERS and any("area" in recipe.goals for recipe in recipes):
            raise PilotError(
                f"pilot is {self.pilot!r}, which reads goals in words, and goals of the recipe has "
                "area; valid: --recipe words, --recipe search, or a recipe with other goals"
            )
        if not self.is_external:
            pilot_of(self.pilot, chat=self.chat)
        elif self.program is not None:
            words_of(self.program)

    def to_plain(self) -> dict[str, Any]:
        """Return what decides the outcome, as plain data."""
        return {
            "recipe": asdict(self.recipe),
            "families": {name: asdict(recipe) for name, recipe in self.families.items()},
            "pilot": self.pilot,
            "program": self.program,
            "endpoint": None if self.chat is None else self.chat.endpoint,
            "model": None if self.chat is None else self.chat.model,
            **self._policy_to_plain(),
            "equipment": self.equipment.to_plain(),
            **({"autopilot": None} if self.stack is None else self.stack.to_plain()),
        }

    def _policy_to_plain(self) -> dict[str, str]:
        """Return the digest of a learnt policy: another file of the same name flies otherwise."""
        if not self.pilot.startswith(POLICY):
            return {}
        from scenarios.policies.policy import digest

        return {"policy_sha256": digest(Path(self.pilot.removeprefix(POLICY)))}


class Flyer:
    """Flies trials of a suite by their names."""

    def __init__(
        self,
        suite: Suite,
        *,
        patience_s: float = math.inf,
        port: int | None = None,
        instance: int = 0,
        shows_program: bool = False,
    ) -> None:
        """Prepare to fly.

        Args:
            suite: Suite to fly.
            patience_s: Wall time for a trial of a pilot outside this process.
            port: TCP port for such a pilot; None takes the usual one, or any for a program.
            instance: Offset of the ports of a flight stack of another project.
            shows_program: True to show the output of a program.

        Raises:
            PilotError: If the suite's pilot is not there.
            ProgramError: If its program is not there.
        """
        self._suite = suite
        self._instance = instance
        self._external = None
        self._pilot = NamedPilot()
        if suite.is_external:
            self._external = ExternalFlights(
                suite.program, patience_s=patience_s, port=port, is_shown=shows_program
            )
        else:
            self._pilot = _guarded(pilot_of(suite.pilot, chat=suite.chat), suite.pilot)
        self._hangar = Hangar()
        self._samplers: OrderedDict[tuple[str, str, str], Sampler] = OrderedDict()

    def task(self, trial: Trial) -> Task:
        """Draw the task of a trial.

        Raises:
            NoTaskError: If the scene has none for the vehicle.
            SceneError: If there is no such scene.
        """
        # Popped and put back: the dictionary's order is that of the last use.
        key = (trial.family, trial.scene, trial.vehicle)
        sampler = self._samplers.pop(key, None)
        if sampler is None:
            # Distance fields of earlier scenes take memory that a new one needs. Another vehicle or
            # family in the same scene uses its field again.
            if all(scene_name != trial.scene for _, scene_name, _ in self._samplers):
                field_cache.forget()
            scene, airframe = self._hangar.scene(trial.scene), airframe_by_name(trial.vehicle)
            recipe = self._suite.recipe_of(trial.family)
            sampler = Sampler(trial.scene, scene, airframe, recipe, trial.family)
        self._samplers[key] = sampler
        if len(self._samplers) > _KEPT_SAMPLERS:
            self._samplers.popitem(last=False)
        return sampler.task(trial.number)

    def fly(self, trial: Trial) -> Row:
        """Draw the task of a trial, fly it, judge it, and record it as the suite says.

        Returns:
            The row of the trial, even if there was no flight. Its `recording` is None if none was
            asked for, or if it could not be written whole.

        Raises:
            INPUT_ERRORS: If the machine does not allow any flight.
            OSError: If the folder of the recordings cannot be made.
        """
        began_s = time.process_time()
        row = blank_row(trial)
        recorded = self._recorded(trial)
        try:
            task = self._lit(self.task(trial))
            row |= task.to_plain()
            row |= self._flown(task, recorded)
        except (NoTaskError, WorldError, TrafficError) as error:
            row |= {"code": NoFlightCode.NO_TASK.value, "reason": _one_line(error)}
        # Other input errors concern the machine, so they end the campaign.
        except INPUT_ERRORS as error:
            if not isinstance(error.__cause__, MissionError):
                raise
            row |= failure(NoFlightCode.NO_PLAN, _one_line(error))
        except SilentError as error:
            row |= failure(NoFlightCode.HUNG, _one_line(error))
        except (CrashedError, ChatError) as error:
            row |= failure(NoFlightCode.RAISED, _one_line(error))
        except Exception as error:  # noqa: BLE001 - a user's pilot may raise anything
            _LOG.info("trial %s", trial.id, exc_info=True)
            cause = (isinstance(error, PilotFaultError) and error.__cause__) or error
            row |= failure(NoFlightCode.RAISED, f"{type(cause).__name__}: {_one_line(cause)}")
        row["grade"] = grade(row)
        return row | {"trial_cpu_seconds": round(time.process_time() - began_s, 3)}

    def _lit(self, task: Task) -> Task:
        """Return the task with the light that is flown, in words, also if its seed draws it."""
        weather = self._suite.equipment.fitted(task.cfg()).bench.weather
        return replace(task, light=str(weather), season=weather.season)

    def _recorded(self, trial: Trial) -> dict[str, Any]:
        """Return the options of a run that record it; an unfinished recording is replaced."""
        recordings = self._suite.recordings
        if recordings is None:
            return {}
        recordings.folder.mkdir(parents=True, exist_ok=True)
        return {
            "record": recordings.path(trial.id),
            "record_level": recordings.level,
            "camera_hz": recordings.camera_hz,
        }

    def _flown(self, task: Task, recorded: dict[str, Any]) -> Row:
        cfg = replace(self._pilot.brief(task.cfg()), **recorded)
        cfg = self._suite.equipment.fitted(cfg)
        if (stack := self._suite.stack) is not None:
            cfg = replace(cfg, bench=stack.flying(cfg.bench, self._instance))
        scene = task.place(self._hangar.scene(task.scene))
        if self._external is not None:
            sitl, result = self._external.fly(task, cfg, scene, self._hangar)
        else:
            make = self._pilot.make
            with Sitl(cfg, scene=scene, pilot=make, has_network=False, hangar=self._hangar) as sitl:
                result = sitl.run()
        # Pilots of others need not say what they plan.
        planned = getattr(sitl.flights[0].companion, "planned_enu_m", None)
        flown_enu_m = sitl.flights[0].log.track()
        goal = next(area for area in scene.interaction_areas if area.id == task.area)
        has_reached = result.navigation_s is not None
        return {
            **result.to_plain(),
            "spl": _spl(task, result),
            **(failure(NoFlightCode.HUNG, result.reason) if sitl.bench.fault else {}),
            "recording": None if sitl.missing else result.recording,
            "flown_enu_m": flown_enu_m,
            "progress": progress(
                np.array(flown_enu_m), np.array(goal.centroid), has_reached=has_reached
            ),
            "planned_enu_m": None if planned is None else track_of(planned),
            # The task's own fields win. The result rounds the start, and for a goal in words it
            # names the area on which the flight ended. Trials of one task with and without a flight
            # could then not be compared.
            **task.to_plain(),
        }

    def close(self) -> None:
        """Close scenes, renderers and programs that were kept."""
        self._hangar.close()
        if self._external is not None:
            self._external.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()


def _spl(task: Task, result: TrialResult) -> float | None:
    """Return the success weighted by path length, of a flight to a goal in words."""
    if result.path_m is None:
        return None
    weight = spl(success=result.success is True, way_m=task.way.way_m, path_m=result.path_m)
    return round(weight, 4)


def _guarded(pilot: NamedPilot, name: str) -> NamedPilot:
    """A pilot whose errors can be distinguished from the testbench's own, if it is a user's."""
    # Our own code flies a policy, and no plan of it is no fault of the policy's.
    if pilot.make is None or ":" not in name or name.startswith(POLICY):
        return pilot
    return replace(pilot, make=partial(UserPilot, pilot.make))


def blank_row(trial: Trial) -> Row:
    """Return what is known of a trial before it is flown."""
    return {
        "trial_id": trial.id,
        "scene": trial.scene,
        "vehicle": trial.vehicle,
        "trial": trial.number,
        "family": trial.family,
        "success": None,
        "version": __version__,
    }


def failure(code: NoFlightCode, reason: str) -> Row:
    """Return the part of a row of a trial that failed without a flight to judge."""
    return {"success": False, "code": code.value, "reason": reason}


def _one_line(error: BaseException) -> str:
    return " ".join(str(error).split())
