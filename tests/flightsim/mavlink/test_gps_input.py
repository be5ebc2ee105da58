"""GPS_INPUT takes the receiver's place, true or forged, and gives it back."""

import math

import pytest

from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.personalities import ARDUPILOT
from tests.flightsim.mavlink.conftest import START_ENU_M, Flight
from tests.flightsim.mavlink.wire import named

_NO_HEIGHT = mav.GPS_INPUT_IGNORE_FLAG_ALT


def _texts(flight):
    return "".join(m.text for m in named(flight.heard, "STATUSTEXT"))


def _tell_place(flight, north_m, *, fix_type=3, flags=0, gps_id=0, lat=None):
    """A fix that lies so far north of where the vehicle stands."""
    east, north, _ = START_ENU_M
    place = flight.frame.geodetic_from_enu((east, north + north_m, 0.1))
    lat = round(place.latitude_deg * 1e7) if lat is None else lat
    flight.send(
        "GPS_INPUT",
        *(flight.plant.time_us, gps_id, flags, 0, 0, fix_type, lat),
        *(round(place.longitude_deg * 1e7), place.altitude_m),
        *(0.8, 0.8, 0.0, 0.0, 0.0, 0.2, 0.5, 0.7, 11),
    )


def _stream(flight, n_fixes, north_m, **fields):
    for _ in range(n_fixes):
        _tell_place(flight, north_m, **fields)
        flight.step(10)


def _north_m(flight):
    return flight.plant.estimate.position_enu_m[1] - START_ENU_M[1]


def test_a_forged_place_shows_in_gps_raw_int_and_drags_the_estimate_along(flight):
    flight.become_ready()
    _stream(flight, 30, 60.0)
    raw = flight.last("GPS_RAW_INT")
    place = flight.frame.geodetic_from_enu((START_ENU_M[0], START_ENU_M[1] + 60.0, 0.0))
    assert raw.lat == pytest.approx(place.latitude_deg * 1e7, abs=3)
    assert (raw.fix_type, raw.satellites_visible) == (3, 11)
    assert (raw.h_acc, raw.v_acc) == (500, 700)
    assert _north_m(flight) == pytest.approx(60.0, abs=0.5)
    assert flight.plant.truth.position_enu_m[1] == pytest.approx(START_ENU_M[1], abs=0.01)
    assert _texts(flight).count("GPS_INPUT takes the place of the vehicle's GPS receiver") == 1


def test_the_receiver_is_back_after_the_last_fix(flight):
    flight.become_ready()
    _stream(flight, 3, 0.2)
    flight.run(8.0)
    assert "GPS_INPUT lost: the vehicle's receiver is back" in _texts(flight)
    gnss = flight.plant.sensors.gnss
    assert (gnss.fix_type, gnss.eph_m < 0.2) == (6, True)
    assert _north_m(flight) == pytest.approx(0.0, abs=0.3)


@pytest.mark.parametrize(
    ("fields", "reason"),
    [
        ({"gps_id": 1}, "gps_id = 1; valid is 0"),
        ({"lat": 900_000_001}, "is off the globe"),
        ({"lat": 10_000_000}, "it lies farther than 100 km from the scene"),
    ],
)
def test_a_fix_that_cannot_be_is_refused_once_and_changes_nothing(flight, fields, reason):
    flight.become_ready()
    before = flight.plant.sensors.gnss
    _stream(flight, 3, 1.0, **fields)
    assert _texts(flight).count("GPS_INPUT refused: ") == 1
    assert reason in _texts(flight)
    assert flight.plant.sensors.gnss.fix_type == before.fix_type
    assert not flight.plant.external_aids.is_fed_fixes


def test_without_a_fix_or_a_height_no_more_is_used_than_there_is(flight):
    flight.become_ready()
    _stream(flight, 2, 30.0, fix_type=1)
    assert flight.plant.sensors.gnss.fix_type == 1
    assert _north_m(flight) == pytest.approx(0.0, abs=0.3)
    up_m = flight.plant.estimate.position_enu_m[2]
    _stream(flight, 5, 0.0, flags=_NO_HEIGHT)
    assert flight.plant.estimate.position_enu_m[2] == pytest.approx(up_m, abs=0.1)


def test_arducopter_uses_it_where_gps_type_says_so(field):
    copter = Flight(field, ARDUPILOT)
    try:
        copter.send("HEARTBEAT", 6, 8, 0, 0, 4, 3)
        copter.become_ready()
        _stream(copter, 3, 60.0)
        assert "GPS_INPUT is not used: GPS_TYPE = 14 lets it be used" in _texts(copter)
        assert copter.plant.sensors.gnss.fix_type == 6
        copter.send("PARAM_SET", 1, 1, b"GPS_TYPE", 14.0, 9)
        copter.step(2)
        assert copter.plant.sensors.gnss.fix_type == 1
        _stream(copter, 3, 60.0)
        assert copter.plant.sensors.gnss.fix_type == 3
        copter.run(3.0)
        assert "GPS_INPUT lost: there is no GPS fix" in _texts(copter)
        assert math.isinf(copter.plant.sensors.gnss.eph_m)
    finally:
        copter.close()
