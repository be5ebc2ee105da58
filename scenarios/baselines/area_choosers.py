"""Baselines for goals in words: our pilot, flown to an area that a simple rule chooses.

Each of them knows all areas, even if the map is not given, and flies with the same pilot. They
therefore differ in the use of the text and in nothing else.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from aeroscene.scene import InteractionArea
from flightsim.draws import generator
from flightsim.testbench import TestbenchError
from scenarios.mission.goals import fitting_areas
from scenarios.mission.mission import plan_mission
from scenarios.mission.surroundings import MissionError
from scenarios.pilot import Pilot
from scenarios.run.companion import Aboard, Insight
from scenarios.words.perfect_perception import perceived_areas
from scenarios.words.site import site_of
from scenarios.words.vocabulary import NOUNS

Rule = Callable[[Aboard, Insight], Sequence[InteractionArea]]
"""Function that returns the areas to fly to, the best first. If no plan leads to one, the next is
taken."""
_MOST_PLANS = 8


@dataclass(frozen=True)
class AreaChooser:
    """Maker of pilots that fly to the first area of a rule."""

    rule: Rule
    has_insight: bool = True
    """Mark that the run reads, so that it gives `Aboard.insight` to the pilot."""

    def __call__(self, aboard: Aboard) -> Pilot:
        """Return a pilot for one flight.

        Args:
            aboard: Equipment, with the insight into the scene.

        Raises:
            TestbenchError: If the goal is not in words, or no area can be flown to.
        """
        if aboard.insight is None:
            raise TestbenchError(
                "this pilot chooses an area by a text, and the goal is an area; "
                "valid: goals naming, relation or chain"
            )
        areas = self.rule(aboard, aboard.insight)
        fault = MissionError("the rule chooses no area")
        for area in areas[:_MOST_PLANS]:
            try:
                mission = plan_mission(
                    aboard.insight.scene,
                    aboard.airframe,
                    area=area,
                    map_source="truth" if aboard.scene.objects else "onboard",
                )
            except MissionError as error:
                fault = error
                continue
            # Without alternates, which our pilot would fly to without asking the rule.
            return Pilot(aboard.client, replace(mission, alternates=()), aboard.render)
        raise TestbenchError(str(fault)) from fault


def at_random(aboard: Aboard, insight: Insight) -> Sequence[InteractionArea]:
    """Return the areas that the vehicle fits on in random order, whatever the text says."""
    areas = fitting_areas(insight.scene, aboard.airframe)
    # The text is part of the seed, so that two goals in one scene get different draws.
    order = generator(0, insight.scene.scene_id, "random area", aboard.text).permutation(len(areas))
    return [areas[i] for i in order]


def nearest_of_kind(aboard: Aboard, insight: Insight) -> Sequence[InteractionArea]:
    """Return the areas on places of the kind that the text names first, the nearest first.

    The rule reads one noun of the text. Distances are from the start of the flight.
    """
    kind = first_kind(aboard.text)
    site = site_of(insight.scene)
    areas = [
        area
        for area in fitting_areas(insight.scene, aboard.airframe)
        if (place := site.place_of(area.object_id)) is not None and place.kind == kind
    ]
    start = insight.scene.start_position_enu_m
    return sorted(areas, key=lambda area: math.dist(area.centroid, start))


def of_the_one(aboard: Aboard, insight: Insight) -> Sequence[InteractionArea]:
    """Return the areas of the only place that the text fits, by perfect perception and reading.

    The rule evaluates the meaning of the text on the scene graph itself, without segmentation and
    without reading English. It is therefore an upper bound for every pilot that looks and reads.
    """
    return perceived_areas(insight.scene, insight.description, aboard.airframe)


def first_kind(text: str) -> str | None:
    """Return the kind of the first noun of a text, None without any.

    Args:
        text: Goal in words. If two nouns begin at the same word, the longer one counts.
    """
    found = [
        (match.start(), -len(noun), kind)
        for kind, (noun, _) in NOUNS.items()
        if (match := re.search(rf"\b{noun}\b", text.lower())) is not None
    ]
    return min(found)[2] if found else None


RANDOM = AreaChooser(at_random)
NEAREST = AreaChooser(nearest_of_kind)
PERFECT = AreaChooser(of_the_one)
