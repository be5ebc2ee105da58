"""The table of states: nothing dangles, and from the air there is always a way out."""

import re
from pathlib import Path

import pytest

from scenarios.pilot.phases import (
    IN_THE_AIR,
    TIME_LIMIT_S,
    TRANSITIONS,
    Phase,
    Transition,
    TransitionError,
)

ENDS = {Phase.DONE, Phase.FAILED}
PAGE = Path(__file__).parents[3] / "docs" / "pilot.md"
DRAWING = PAGE.parent / "images" / "pilot_states.svg"


def reached_from(phase):
    found, todo = {phase}, [phase]
    while todo:
        for target in TRANSITIONS[todo.pop()] - found:
            found.add(target)
            todo.append(target)
    return found


def test_every_phase_is_in_the_table_and_can_be_reached():
    assert set(TRANSITIONS) == set(Phase)
    assert reached_from(Phase.CONNECT) == set(Phase)


@pytest.mark.parametrize("phase", [phase for phase in Phase if phase not in ENDS])
def test_every_phase_can_end_well_or_badly_and_in_time(phase):
    assert Phase.FAILED in reached_from(phase)
    assert TIME_LIMIT_S[phase] > 0
    assert phase not in TRANSITIONS[phase]


@pytest.mark.parametrize("phase", sorted(IN_THE_AIR, key=lambda phase: phase.value))
def test_from_every_phase_in_the_air_it_can_wait_go_home_or_hand_over(phase):
    targets = TRANSITIONS[phase] | {phase}
    assert {Phase.HOLD, Phase.RETURN, Phase.HAND_OVER, Phase.FAILED} <= targets


def test_what_flies_counts_as_in_the_air():
    on_the_ground = {
        Phase.CONNECT,
        Phase.PREPARE,
        Phase.ARM,
        Phase.DISARM,
        Phase.HAND_OVER,
        *ENDS,
    }
    assert set(Phase) - IN_THE_AIR == on_the_ground


def test_the_end_is_the_end():
    assert all(not TRANSITIONS[phase] for phase in ENDS)


def test_a_change_that_is_not_in_the_table_is_refused_with_what_would_be():
    with pytest.raises(
        TransitionError, match="phase touch down does not follow connect; valid: failed, wait for"
    ):
        Transition(time_us=0, source=Phase.CONNECT, target=Phase.TOUCHDOWN, reason="because")


@pytest.mark.parametrize("phase", [Phase.SEARCH, Phase.ALIGN, Phase.CLIMB, Phase.HOLD])
def test_an_area_that_is_given_up_is_left_for_the_next(phase):
    assert Phase.NAVIGATE in TRANSITIONS[phase]


def drawn(pattern, text):
    """Changes of state that a text shows, by the names of the phases."""
    names = {phase.name.lower(): phase for phase in Phase}
    return {(names[a], names[b]) for a, b in re.findall(pattern, text, re.MULTILINE)}


@pytest.mark.parametrize(
    ("path", "pattern"),
    [(PAGE, r"^\| `(\w+)` \| `(\w+)` \|"), (DRAWING, r'id="(\w+)-(\w+)"')],
    ids=["table", "drawing"],
)
def test_the_page_shows_the_table(path, pattern):
    """All but the exits, which every phase in the air has and the page names in a sentence."""
    exits = {Phase.HOLD, Phase.RETURN, Phase.HAND_OVER, Phase.FAILED}
    table = {(source, target) for source in Phase for target in TRANSITIONS[source]}
    shown = drawn(pattern, path.read_text())
    assert {edge for edge in shown if edge[1] not in exits} == {
        edge for edge in table if edge[1] not in exits
    }
    assert shown <= table
