import math

import pytest

from flightsim.vehicles.catalogue import AIRFRAMES, AirframeError, airframe_by_name

EACH = pytest.mark.parametrize("airframe", AIRFRAMES.values(), ids=lambda a: a.name)


@EACH
def test_thrust_and_reaction_torque_balance_in_hover(airframe):
    rotors = airframe.quadrotor.rotors
    speed = airframe.battery.hover_rotor_speed_radps
    thrusts = [r.thrust_constant * speed**2 for r in rotors]
    weight_n = airframe.quadrotor.mass_kg * 9.81
    assert sum(thrusts) == pytest.approx(weight_n)
    assert sum(r.spin for r in rotors) == 0
    # The Typhoon's centre of mass lies 5 mm behind the middle of its rotors.
    offset_m = 0.006 if airframe.name == "typhoon" else 1e-9
    for axis in (0, 1):
        moments = (t * r.position_flu_m[axis] for t, r in zip(thrusts, rotors, strict=True))
        assert abs(sum(moments)) <= offset_m * weight_n


@EACH
def test_inertia_is_that_of_a_possible_body(airframe):
    x, y, z = airframe.quadrotor.inertia_flu_kgm2
    assert x + y >= z
    assert y + z >= x
    assert z + x >= y


@EACH
def test_collision_radius_holds_every_disc_and_no_disc_meets_another(airframe):
    hubs = [r.position_flu_m for r in airframe.quadrotor.rotors]
    for i, hub in enumerate(hubs):
        reach = math.hypot(hub[0], hub[1]) + airframe.rotor_radius_m
        assert reach <= airframe.collision_radius_m + 1e-12
        for other in hubs[:i]:
            assert math.dist(hub, other) > 2 * airframe.rotor_radius_m


def test_thrust_to_weight_is_the_published_one():
    ratios = {name: 1 / a.quadrotor.hover_thrust_fraction for name, a in AIRFRAMES.items()}
    published = {"iris": 1.88, "iris-rotors": 1.59, "hummingbird": 3.35}
    assert ratios == pytest.approx({**published, "crazyflie": 1.9, "typhoon": 4.41}, 0.01)


def test_unknown_vehicle_is_named_with_the_valid_ones():
    with pytest.raises(AirframeError) as caught:
        airframe_by_name("boeing")
    assert str(caught.value) == (
        "vehicle 'boeing' is unknown; valid: iris, iris-rotors, hummingbird, crazyflie, typhoon, "
        "or a file FILE.toml"
    )
