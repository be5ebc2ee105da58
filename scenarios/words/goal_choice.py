"""Choice of the goal in words of a run: for a given area, or for the first that a seed draws."""

from __future__ import annotations

from typing import Literal

from aeroscene.scene import InteractionArea, Scene
from flightsim.draws import generator
from flightsim.testbench import TestbenchError
from flightsim.vehicles.airframe import Airframe
from scenarios.mission.goals import draw_goals, fits
from scenarios.words.goal import GRADES, Grade
from scenarios.words.goal_drawing import WordGoal, draw_goal

Asked = Literal["words"] | Grade
"""Grade of a text, or any of them."""


class WordsError(TestbenchError):
    """A scene has no goal in words; the message names it and what would be valid."""


def choose_goal(
    scene: Scene,
    airframe: Airframe,
    *,
    asked: Asked,
    seed: int,
    area: InteractionArea | None = None,
) -> WordGoal:
    """Return the goal in words of a run.

    Args:
        scene: Scene with its start.
        airframe: Vehicle that must fit on the areas.
        asked: Grade of the text; `words` draws one.
        seed: Seed of all draws; the same seed gives the same text.
        area: Area whose place the text means; None draws one.

    Returns:
        The goal, with those of the place's areas that the vehicle fits on.

    Raises:
        WordsError: If no text of the grade fits any such place alone.
    """
    grades: list[Grade] = [grade for grade in GRADES if asked in {"words", grade}]
    rng = generator(seed, scene.scene_id, "grade")
    # A stream of its own for the order, so that areas and texts do not depend on it.
    order = [grades[i] for i in rng.permutation(len(grades))]
    # Areas outside, grades inside: the drawn area is kept if any grade has a text for it.
    for candidate in draw_goals(scene, airframe, seed) if area is None else [area]:
        for grade in order:
            goal = draw_goal(scene, candidate, grade, seed)
            if goal is not None:
                return fitting(goal, airframe)
    whose = "any area" if area is None else f"area {area.id}"
    valid = "another scene" if area is None else "another area"
    raise WordsError(
        f"goal {asked}: scene {scene.scene_id} has no text that fits the place of {whose} alone; "
        f"valid: {valid}{'' if asked == 'words' else ', or --goal words'}"
    )


def fitting(goal: WordGoal, airframe: Airframe) -> WordGoal:
    """Return the goal with only those of its areas that a vehicle fits on."""
    areas = tuple(area for area in goal.areas if fits(area, airframe))
    return WordGoal(text=goal.text, description=goal.description, areas=areas)
