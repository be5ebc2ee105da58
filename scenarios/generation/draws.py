"""Draws of scenes until each meets its wishes, written as they are found.

A generative model follows wishes only roughly, and some draws cannot be made flyable at all. Each
seed is therefore drawn again, with the attempt's number as a second seed, until a `Judge` keeps a
scene. A scene that misses wishes of a prompt is set aside, and the best one of a seed is written if
no draw meets all. Results go into a `Tally` and to disk at once, so that an interrupted command
loses no scene.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, Protocol

from aeroscene.feasibility.wishes.passages import narrowest
from aeroscene.files.names import file_name
from aeroscene.metrics.collision import collision_rate
from aeroscene.scene import AttributeValue, Scene
from aeroscene.scene.io import write_scene
from scenarios.generation.prompts.wishes import Count
from scenarios.generation.wish_outcomes import (
    WishOutcome,
    beside_demands,
    beside_wishes,
    shortfall,
    unmet,
    with_demands,
    with_measures,
)

if TYPE_CHECKING:
    from aeroscene.learning.generation import Generated, Generator, Request
    from scenarios.mission.difficulty import Grade

MOST_GRADED_DRAWS = 24
"""Greatest number of draws of a seed if a difficulty is asked for: a third of scenes has each."""


class Judge(Protocol):
    """Decides whether a sound scene is one that was asked for."""

    most_draws: int
    """Number of draws after which a seed is given up."""

    def judged(self, scene: Scene) -> tuple[Scene, str | None]:
        """Measure a scene and decide on it.

        Args:
            scene: Scene that can be flown.

        Returns:
            The scene with its measured figures, and the reason why it is not kept, None if it is.
        """
        ...


class AnyScene:
    """Keeps every scene, with the width of its passages if that was asked for."""

    def __init__(self, most_draws: int) -> None:
        self.most_draws = most_draws

    def judged(self, scene: Scene) -> tuple[Scene, str | None]:
        """Keep the scene."""
        return with_passages(scene), None


class OfDifficulty:
    """Keeps scenes of one class of difficulty for an Iris."""

    most_draws = MOST_GRADED_DRAWS

    def __init__(self, grade: Grade) -> None:
        self._grade = grade
        self._seen: dict[int, Counter[str]] = {}

    def judged(self, scene: Scene) -> tuple[Scene, str | None]:
        """Measure the difficulty of a scene, and keep it if it is of the class.

        A scene of another class, or one without any path to an area, is drawn again.
        """
        # CasADi and the kernels of planning are loaded only if somebody asks for a difficulty.
        from flightsim.vehicles.catalogue import airframe_by_name
        from scenarios.mission.difficulty import measure_difficulty
        from scenarios.mission.surroundings import MissionError

        seen = self._seen.setdefault(scene.seed, Counter())
        try:
            found = measure_difficulty(scene, airframe_by_name("iris"))
        except MissionError:
            seen["without a way"] += 1
            return scene, self._reason(seen)
        seen[found.grade] += 1
        wishes = {**scene.wishes, "difficulty": self._grade}
        scene = replace(with_passages(scene), wishes=wishes)
        scene = replace(scene, measured={**scene.measured, **found.to_plain()})
        return scene, None if found.grade == self._grade else self._reason(seen)

    def _reason(self, seen: Counter[str]) -> str:
        found = ", ".join(f"{count} {grade}" for grade, count in sorted(seen.items()))
        return (
            f"no {self._grade} scene in {self.most_draws} draws, of which sound: {found}; "
            "valid: another seed, domain or difficulty"
        )


def with_passages(scene: Scene) -> Scene:
    """Return the scene with the width of its narrowest passage, if a least width was asked for.

    Args:
        scene: Any scene; without the wish it is returned as it is.
    """
    if "min_passage" not in scene.wishes:
        return scene
    found = narrowest(scene)
    width: dict[str, AttributeValue] = (
        {} if found is None else {"min_passage": round(found.width_m, 3)}
    )
    return replace(scene, measured={**scene.measured, **width})


class _SetAside(NamedTuple):
    """Best draw of a seed so far among those that miss a wish of the prompt."""

    shortfall: tuple[int, float]
    scene: Scene
    wishes: dict[str, WishOutcome]


@dataclass
class Tally:
    """Results of the draws so far, and the writer of scenes that are kept."""

    out: Path
    """Folder of the scenes."""
    files: list[str] = field(default_factory=list)
    failed: dict[int, str] = field(default_factory=dict)
    """Reason why a seed gave no scene, by seed."""
    unfit: dict[int, str] = field(default_factory=dict)
    """Reason why the sound scenes of a seed were not kept, by seed."""
    is_strict: bool = False
    """True draws scenes that miss a wish again, and never keeps them."""
    prompt: str = ""
    """Prompt of the user; if there is one, a seed is drawn until it meets all wishes."""
    demands: Sequence[Count] = ()
    """Counts and relations of the prompt."""
    wishes: dict[str, dict[str, WishOutcome]] = field(default_factory=dict)
    """Each wish beside the figure of the scene, for the scenes that are kept, by file."""
    measured: dict[str, dict[str, AttributeValue]] = field(default_factory=dict)
    """Measured figures of the scenes that are kept, by file."""
    n_rejected: int = 0
    sampled: list[float] = field(default_factory=list)
    """Collision rates of all draws."""
    feasible: list[float] = field(default_factory=list)
    """Collision rates of the finished scenes."""
    seconds: float = 0.0
    _aside: dict[int, _SetAside] = field(default_factory=dict)
    """Best draws that miss a wish, by seed."""

    def keep(self, found: Generated, judge: Judge) -> bool:
        """Judge a draw, and write its scene if it is kept.

        Args:
            found: Draw, whose scene is None if it was not sound.
            judge: Decides whether a sound scene is kept.

        Returns:
            True if the draw gave a scene that is kept.
        """
        self.sampled.append(collision_rate(found.raw))
        scene, reason = found.scene, str(found.report.rejection)
        if scene is not None:
            scene, unfit = judge.judged(scene)
            scene = with_demands(scene, self.prompt, self.demands)
            wishes = beside_wishes(found, scene) | beside_demands(scene, self.demands)
            missed = unmet(wishes)
            if unfit is None and missed and self.is_strict:
                unfit = (
                    f"the last of {judge.most_draws} draws has {missed}; "
                    "valid: wishes nearer to that, another seed, or no --strict"
                )
            # A scene that misses a wish of a prompt waits, since a later draw may meet all.
            if unfit is None and not (missed and self.prompt):
                self.write(scene, wishes)
                return True
            if unfit is None:
                self._set_aside(scene, wishes)
            else:
                self.unfit[scene.seed] = unfit
        self.n_rejected += 1
        # If sound scenes were not as asked for, that says more than the fault of an unsound draw.
        self.failed[found.request.seed] = self.unfit.get(found.request.seed, reason)
        return False

    def keep_best(self, seed: int) -> bool:
        """Write the best draw of a seed whose draws all miss a wish.

        Args:
            seed: Seed whose draws are used up.

        Returns:
            True if there was such a draw.
        """
        best = self._aside.pop(seed, None)
        if best is None:
            return False
        # It was counted as rejected when it was set aside.
        self.n_rejected -= 1
        self.write(best.scene, best.wishes)
        return True

    def best_of(self, seed: int) -> Scene | None:
        """Return the best draw of a seed so far that misses a wish, None if there is none."""
        best = self._aside.get(seed)
        return None if best is None else best.scene

    def _set_aside(self, scene: Scene, wishes: dict[str, WishOutcome]) -> None:
        before, now = self._aside.get(scene.seed), shortfall(wishes)
        if before is None or now < before.shortfall:
            self._aside[scene.seed] = _SetAside(now, scene, wishes)

    def write(self, scene: Scene, wishes: dict[str, WishOutcome]) -> None:
        """Write a scene that is kept.

        Args:
            scene: Scene; its file takes its id.
            wishes: Wishes beside its figures, which its document names too.
        """
        scene = with_measures(scene, wishes)
        self.failed.pop(scene.seed, None)
        self._aside.pop(scene.seed, None)
        self.feasible.append(collision_rate(scene))
        path = self.out / f"{file_name(scene.scene_id)}.json"
        write_scene(scene, path)
        self.files.append(str(path))
        if wishes:
            self.wishes[str(path)] = wishes
        if scene.measured:
            self.measured[str(path)] = dict(scene.measured)


def draw_all(
    generator: Generator,
    requests: Sequence[Request],
    judge: Judge,
    tally: Tally,
    *,
    batch_size: int,
    advance: Callable[[], None],
) -> None:
    """Draw every request until it gives a scene or its draws are used up.

    Args:
        generator: The model.
        requests: One request for each seed.
        judge: Decides which draws are kept.
        tally: Takes the draws.
        batch_size: Number of scenes that are denoised at once.
        advance: Called once for each request that is done.
    """
    pending = list(requests)
    # All requests are drawn once, then those that failed are drawn again, so that batches are full.
    for attempt in range(judge.most_draws):
        drawn, pending = pending, []
        began_s = time.perf_counter()
        for found in generator.generate(drawn, batch_size=batch_size, attempt=attempt):
            tally.seconds += time.perf_counter() - began_s
            is_kept = tally.keep(found, judge)
            if not is_kept:
                pending.append(found.request)
            if is_kept or attempt == judge.most_draws - 1:
                advance()
            # The time of judging, which may plan flights, is not the model's.
            began_s = time.perf_counter()
    for request in pending:
        tally.keep_best(request.seed)


def draw_with_pictures(
    generator: Generator, request: Request, judge: Judge, tally: Tally, picture: Path
) -> None:
    """Draw one request as `draw_all` does, with pictures of the denoising of the draw that counts.

    The draw that counts is the kept one, else the best that misses a wish, else the last.

    Args:
        generator: The model.
        request: Request to draw.
        judge: Decides which draws are kept.
        tally: Takes the draws.
        picture: PNG file to write.
    """
    from scenarios.pictures.generation.recorder import Recorder

    shown: tuple[Recorder, Generated] | None = None
    for attempt in range(judge.most_draws):
        recorder = Recorder()
        began_s = time.perf_counter()
        found = next(generator.generate([request], attempt=attempt, on_step=recorder))
        tally.seconds += time.perf_counter() - began_s
        # A change of the best tells that this draw took its place.
        before = tally.best_of(request.seed)
        is_kept = tally.keep(found, judge)
        best = tally.best_of(request.seed)
        if is_kept or best is None or best is not before:
            shown = recorder, found
        if is_kept:
            break
    tally.keep_best(request.seed)
    if shown is not None:
        shown[0].draw(shown[1], picture)
