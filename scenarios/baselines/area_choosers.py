"""Baselines for goals in words: our pilot, flown to an area that a simple rule chooses.

Each of them knows where all areas are, also where the map is not given. So they differ in what they
make of the text and in nothing else.
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
from scenarios.words.perceiving import perceived_areas
from scenarios.words.site import site_of
from scenarios.words.vocabulary import NOUNS

Rule = Callable[[Aboard, Insight], Sequence[InteractionArea]]
"""Areas to fly to, the best first; the next one is taken where no plan leads to the one before."""
_MOST_PLANS = 8


@dataclass(frozen=True)
class AreaChooser:
    """Makes our pilot fly to the first area of a rule."""

    rule: Rule
    has_insight: bool = True
    """Read by the run: see `Aboard.insight`."""

    def __call__(self, aboard: Aboard) -> Pilot:
        """A pilot for a flight.

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
            return Pilot(aboard.client, replace(mission, alternates=()), aboard.render)
        raise TestbenchError(str(fault)) from fault


def at_random(aboard: Aboard, insight: Insight) -> Sequence[InteractionArea]:
    """Any area that the vehicle fits on, with equal chance, whatever the text says."""
    areas = fitting_areas(insight.scene, aboard.airframe)
    order = generator(0, insight.scene.scene_id, "random area", aboard.text).permutation(len(areas))
    return [areas[i] for i in order]


def nearest_of_kind(aboard: Aboard, insight: Insight) -> Sequence[InteractionArea]:
    """The areas on things of the kind that the text names first, the nearest to the start first.

    It reads one word of the text.
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
    """The areas of the only place that the text fits, by perfect perception and perfect reading.

    It evaluates the meaning of the text on the scene graph itself, without segmentation and without
    reading English: a bound for every pilot that looks and reads.
    """
    return perceived_areas(insight.scene, insight.description, aboard.airframe)


def first_kind(text: str) -> str | None:
    """Kind of the noun that comes first in a text, the longest one of several; None without any."""
    found = [
        (match.start(), -len(noun), kind)
        for kind, (noun, _) in NOUNS.items()
        if (match := re.search(rf"\b{noun}\b", text.lower())) is not None
    ]
    return min(found)[2] if found else None


RANDOM = AreaChooser(at_random)
NEAREST = AreaChooser(nearest_of_kind)
PERFECT = AreaChooser(of_the_one)
