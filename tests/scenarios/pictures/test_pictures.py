from dataclasses import replace

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flightsim.vehicles.catalogue import airframe_by_name
from scenarios.pictures import FlightStory, PictureError, draw_pictures, style
from scenarios.pictures.graphs import draw_profile
from scenarios.pictures.landing import draw_landing
from scenarios.pictures.story import LandingLayers, MoverPath, PlannedLeg, Track
from tests.scenarios.landing_scenes import ON_CONTAINER, TOP_M, yard

N = 200
TOUCHDOWN = (9.0, 0.0, TOP_M)


def line(begin, end, n=N):
    return np.linspace(begin, end, n)


def leg(time_s, begin, end):
    return PlannedLeg(time_s=time_s, points_enu_m=line(begin, end, 30), step_s=0.1)


def landing_layers():
    n = 41
    east, north = np.meshgrid(np.linspace(7.0, 11.0, n), np.linspace(-2.0, 2.0, n))
    on_top = (np.abs(north) < 1.1) & (east > 6.5)
    room_m = np.where(on_top, np.maximum(1.1 - np.abs(north) - 0.4, 0.0), 0.0)
    return LandingLayers(
        east_m=east[0],
        north_m=north[:, 0],
        height_m=np.where(on_top, TOP_M, np.nan),
        slope_rad=np.where(on_top, 0.02, np.nan),
        roughness_m=np.where(on_top, 0.1 * np.abs(north), np.nan),
        clearance_m=np.where(on_top, room_m, np.nan),
        is_safe=room_m > 0,
    )


@pytest.fixture(scope="module")
def story():
    up, over = (0.0, 0.0, 4.0), (9.0, 0.0, 5.0)
    true = np.concatenate(
        [line((0, 0, 0.2), up, 50), line(up, over, 100), line(over, TOUCHDOWN, 50)]
    )
    return FlightStory(
        scene=yard(),
        airframe=airframe_by_name("iris"),
        title="yard: landed",
        track=Track(
            time_s=np.arange(N) * 0.05, true_enu_m=true, est_enu_m=true + 0.1, ref_enu_m=true + 0.05
        ),
        phases=((0.0, "take off"), (2.5, "navigate"), (7.5, "descend")),
        plans=(
            leg(0.0, (0, 0, 0.2), up),
            leg(2.5, up, (9.0, 9.0, 5.0)),
            leg(4.0, (3.0, 1.0, 4.3), over),
        ),
        movers=(MoverPath(name="person_0", points_enu_m=line((3, -5, 0.9), (3, 5, 0.9))),),
        area=ON_CONTAINER,
        touchdown_enu_m=TOUCHDOWN,
        landing=landing_layers(),
    )


@pytest.fixture(scope="module")
def pictures(story, tmp_path_factory):
    folder = tmp_path_factory.mktemp("pictures") / "new" / "folder"
    return draw_pictures(story, folder)


def n_pixels(path, colour, tolerance=12):
    rgb = cv2.imread(str(path), cv2.IMREAD_COLOR_RGB).astype(int)
    wanted = [int(colour[i : i + 2], 16) for i in (1, 3, 5)]
    return int((np.abs(rgb - wanted).max(axis=2) <= tolerance).sum())


def test_flight_shows_plans_area_movers_and_errors(pictures):
    flight = pictures[0]
    assert flight.name == "flight.png"
    for colour in (style.PLANNED, style.SUPERSEDED, style.AREA, style.MOVERS[0], style.ESTIMATE):
        assert n_pixels(flight, colour) > 50, colour


def test_landing_map_shows_safe_and_unsafe_ground(pictures):
    landing = pictures[1]
    assert landing.name == "landing.png"
    assert n_pixels(landing, "#3fb56b") > 5000, "safe"
    assert n_pixels(landing, "#d1495b") > 5000, "unsafe"


def test_same_flight_gives_the_same_picture(story, pictures, tmp_path):
    draw_landing(story, [tmp_path / "again.png"])
    assert (tmp_path / "again.png").read_bytes() == pictures[1].read_bytes()


def test_lines_stay_lines_where_that_is_asked_for(story, tmp_path):
    files = draw_pictures(story, tmp_path, ("svg", "pdf"))
    assert [file.name for file in files] == [
        *("flight.svg", "flight.pdf"),
        *("landing.svg", "landing.pdf"),
    ]
    assert files[0].read_bytes().count(b"<path") > 50
    assert files[1].read_bytes().startswith(b"%PDF")


def test_planned_and_flown_are_both_seen_where_one_follows_the_other(story, pictures):
    assert n_pixels(pictures[0], style.PLANNED) > 2000


def test_vehicle_without_a_pilot_that_never_left_the_ground_is_drawn(story, tmp_path):
    here = np.repeat(story.track.true_enu_m[:1], N, axis=0)
    alone = FlightStory(
        scene=story.scene,
        airframe=story.airframe,
        title="by hand",
        track=replace(
            story.track, true_enu_m=here, est_enu_m=here, ref_enu_m=np.full_like(here, np.nan)
        ),
    )
    (flight,) = draw_pictures(alone, tmp_path)
    assert flight.name == "flight.png"
    assert n_pixels(flight, style.PLANNED) == 0


def test_folder_that_cannot_be_written_is_refused_in_one_line(story, tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(PictureError, match="cannot be written") as error:
        draw_pictures(story, tmp_path / "file")
    assert "\n" not in str(error.value)


def test_plan_is_superseded_where_the_next_does_not_begin_at_its_end(story):
    assert story.superseded() == (False, True, False)


@given(st.floats(0.01, 1e5))
def test_scale_is_a_round_length_of_a_tenth_to_a_fifth_of_the_view(span_m):
    length_m = style.round_length_m(span_m)
    assert span_m / 13 < length_m <= span_m / 5 * (1 + 1e-9)
    assert f"{length_m:.0e}"[0] in "125"


def test_every_line_of_the_height_is_named(story):
    axes = style.new_figure(8.0, 4.0).add_subplot()
    ground_m = np.zeros(N)
    for overhead_m, named in ((np.full(N, np.inf), []), (np.full(N, 5.5), ["overhead"])):
        axes.clear()
        draw_profile(axes, story, ground_m, overhead_m, story.track)
        names = [text.get_text() for text in axes.get_legend().get_texts()]
        assert names == ["below", *named, "planned", "flown", "touchdown point"]
