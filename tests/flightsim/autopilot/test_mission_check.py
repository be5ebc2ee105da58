import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from flightsim.autopilot.mission import MissionStore
from flightsim.autopilot.mission_check import MAX_MISSION_ITEMS
from flightsim.autopilot.mission_item import Cmd, MissionError, MissionFault, MissionItem

NAN = math.nan


def waypoint(**fields):
    return MissionItem(**{"frame": 6, "command": Cmd.WAYPOINT, "x": 47.4, "y": 8.5, **fields})


@pytest.mark.parametrize(
    ("bad", "fault", "param"),
    [
        ({"command": 9999}, MissionFault.UNSUPPORTED_COMMAND, None),
        ({"command": Cmd.FENCE_CIRCLE_INCLUSION}, MissionFault.UNSUPPORTED_COMMAND, None),
        ({"frame": 2}, MissionFault.UNSUPPORTED_FRAME, None),
        ({"frame": 99}, MissionFault.UNSUPPORTED_FRAME, None),
        ({"x": NAN}, MissionFault.INVALID_PARAM, 5),
        ({"x": 91.0}, MissionFault.INVALID_PARAM, 5),
        ({"y": math.inf}, MissionFault.INVALID_PARAM, 6),
        ({"z": NAN}, MissionFault.INVALID_PARAM, 7),
        ({"command": Cmd.TAKEOFF, "z": NAN}, MissionFault.INVALID_PARAM, 7),
        ({"param1": math.inf}, MissionFault.INVALID_PARAM, 1),
        ({"command": Cmd.JUMP, "param1": 5.0}, MissionFault.INVALID_PARAM, 1),
        ({"command": Cmd.JUMP, "param1": 0.5}, MissionFault.INVALID_PARAM, 1),
        ({"command": Cmd.JUMP, "param1": NAN}, MissionFault.INVALID_PARAM, 1),
        ({"command": Cmd.CHANGE_SPEED, "frame": 2}, MissionFault.INVALID_PARAM, 2),
        ({"command": Cmd.DELAY, "frame": 2}, MissionFault.INVALID_PARAM, 1),
        ({"command": Cmd.LOITER_TURNS}, MissionFault.INVALID_PARAM, 1),
        ({"command": Cmd.CONDITION_YAW, "frame": 2}, MissionFault.INVALID_PARAM, 1),
    ],
)
def test_a_bad_item_is_refused_with_its_place_and_the_old_mission_remains(bad, fault, param):
    store = MissionStore()
    store.replace([waypoint()])
    with pytest.raises(MissionError) as caught:
        store.replace([waypoint(), waypoint(**bad)])
    assert (caught.value.fault, caught.value.index, caught.value.param) == (fault, 1, param)
    assert "item 1" in str(caught.value)
    assert len(store) == 1


def test_too_many_items_are_refused():
    with pytest.raises(MissionError, match="at most 2000") as caught:
        MissionStore().replace([waypoint()] * (MAX_MISSION_ITEMS + 1))
    assert caught.value.fault is MissionFault.NO_SPACE


@pytest.mark.parametrize(
    "fields",
    [
        {"command": Cmd.LAND, "x": NAN, "y": NAN, "z": NAN},
        {"command": Cmd.TAKEOFF, "x": 0.0, "y": 0.0, "z": 3.0},
        {"command": Cmd.RETURN, "frame": 2},
        {"command": 195},
        {"command": 2000, "frame": 2},
        {"frame": 1, "x": 30.0, "y": -200.0},
        {"command": Cmd.JUMP, "frame": 2, "param1": 0.0, "param2": 2.0},
    ],
)
def test_items_that_leave_things_open_or_have_nothing_to_act_on_are_taken(fields):
    store = MissionStore()
    store.replace([waypoint(**fields)])
    assert len(store) == 1


@given(
    st.lists(
        st.builds(
            MissionItem,
            frame=st.integers(-1, 30),
            command=st.integers(0, 6000) | st.sampled_from(list(Cmd)),
            param1=st.floats(),
            param2=st.floats(),
            param3=st.floats(),
            param4=st.floats(),
            x=st.floats(),
            y=st.floats(),
            z=st.floats(),
        ),
        max_size=4,
    )
)
def test_any_list_of_items_is_stored_whole_or_refused_whole(items):
    store = MissionStore()
    try:
        store.replace(items)
    except MissionError:
        assert store.items == ()
        return
    assert len(store) == len(items)
