"""Flies trials by programs: opens a port for each, sends the task, starts and ends them.

Any MAVLink flight code can take part in a campaign, in any language. It gets the task as one line
of JSON on its standard input, and keeps the time in lockstep.
"""

from __future__ import annotations

import json
from contextlib import AbstractContextManager, nullcontext
from dataclasses import asdict, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from aeroscene.files.names import file_name
from aeroscene.scene import Scene
from aeroscene.scene.io import write_scene
from flightsim.mavlink.links import TcpServerLink
from flightsim.testbench import Testbench
from scenarios.campaigns.external.pilot import ExternalPilot
from scenarios.campaigns.external.program import Program, words_of
from scenarios.run.cfg import SitlCfg
from scenarios.run.hangar import Hangar
from scenarios.run.sitl import Sitl
from scenarios.tasks.task import Task
from scenarios.trials.result import TrialResult

FIRST_PORT = 5760
"""TCP port of instance 0; the port of instance N is 10 N higher."""


class ExternalFlights:
    """Flights of programs, or of clients that connect by themselves."""

    def __init__(
        self, command: str | None, *, patience_s: float, port: int | None, is_shown: bool
    ) -> None:
        """Prepare flights.

        Args:
            command: Program that flies each trial. None waits for a client instead, and writes its
                task to standard output.
            patience_s: Wall time for a trial.
            port: TCP port on loopback; None takes any that is free.
            is_shown: True to show the program's output.

        Raises:
            ProgramError: If there is no such program.
        """
        if command is not None:
            words_of(command)
        self._command = command
        self._patience_s = patience_s
        self._port = port or (0 if command is not None else FIRST_PORT)
        self._is_shown = is_shown
        self._folder = TemporaryDirectory(prefix="aeroscene-")

    def fly(
        self, task: Task, cfg: SitlCfg, scene: Scene, hangar: Hangar
    ) -> tuple[Sitl, TrialResult]:
        """Fly a task.

        Args:
            task: The task.
            cfg: Configuration of its run.
            scene: The scene with the start of the task.
            hangar: Resources that flights share.

        Returns:
            The run, which has ended, and its result.

        Raises:
            INPUT_ERRORS: If the run cannot be opened.
            CrashedError: If the program ends with an error.
            SilentError: If the pilot does not answer.
        """
        link = TcpServerLink(port=self._port, is_lockstep=True)
        # Time stands still until the pilot grants a tick, so its speed does not matter.
        cfg = replace(cfg, demo=False, bench=replace(cfg.bench, lockstep=True))
        with Sitl(
            cfg, scene=scene, pilot=ExternalPilot, has_network=False, hangar=hangar, links=[[link]]
        ) as sitl:
            pilot = sitl.flights[0].companion
            assert isinstance(pilot, ExternalPilot)
            brief = json.dumps(self._brief(task, sitl.bench, link.port))
            with self._pilot(brief) as program:
                pilot.begin(sitl.bench, program, self._patience_s)
                result = sitl.run(pilot.look)
                # Then a client that still waits for a message sees the connection end.
                sitl.bench.close()
        return sitl, result

    def _pilot(self, brief: str) -> AbstractContextManager[Program | None]:
        if self._command is not None:
            return Program(self._command, brief, is_shown=self._is_shown)
        print(brief, flush=True)  # noqa: T201 - whoever flies reads it there
        return nullcontext()

    def _brief(self, task: Task, bench: Testbench, port: int) -> dict[str, Any]:
        """Return the brief of a pilot: the same that ours gets, and nothing of the wind."""
        area = next(each for each in bench.scene.interaction_areas if each.id == task.area)
        # A goal in words replaces the area; both would give the answer away.
        is_named = task.text is None
        keys = ("id", "kind", "centroid", "polygon", "radius", "surface")
        return {
            "trial_id": task.trial_id,
            "url": f"tcp:127.0.0.1:{port}",
            "vehicle": task.vehicle,
            "start_enu_m": task.start,
            "start_yaw_rad": task.start_yaw_rad,
            "local_origin_enu_m": bench.plant.truth.position_enu_m,
            "area": {key: asdict(area)[key] for key in keys} if is_named else None,
            "goal": task.text,
            "time_limit_s": task.time_limit_s,
            "scene_file": str(self._scene_file(bench.scene)) if task.map == "truth" else None,
        }

    def _scene_file(self, scene: Scene) -> Path:
        """Write the scene to a file, anew for the start of each trial, and return its path."""
        path = Path(self._folder.name) / f"{file_name(scene.scene_id)}.json"
        write_scene(scene, path)
        return path

    def close(self) -> None:
        """Remove the files of the scenes."""
        self._folder.cleanup()
