"""Airframes from files: the documented example, what follows from it, and what is refused."""

import math
import re
from pathlib import Path

import mujoco
import numpy as np
import pytest

from autonomy.types import IDLE
from flightsim.plant import Plant, PlantCfg
from flightsim.vehicles.airframe import AirframeError
from flightsim.vehicles.catalogue import airframe_by_name
from flightsim.vehicles.definition import read_airframe
from flightsim.world import build_world
from scenarios.bench.figure_eight import come_back, take_off
from tests.flightsim.handmade import empty_scene

PAGE = Path(__file__).parents[3] / "docs" / "airframes.md"
EXAMPLE = re.search(r"```toml\n(.*?)```", PAGE.read_text(), re.DOTALL)[1]


def read(folder, text):
    path = folder / "my_drone.toml"
    path.write_text(text)
    return read_airframe(path)


def changed(before, after):
    """The example with one line changed."""
    assert EXAMPLE.count(before) >= 1, before
    return EXAMPLE.replace(before, after, 1)


def test_the_documented_example_flies(tmp_path):
    (tmp_path / "f450.toml").write_text(EXAMPLE)
    airframe = airframe_by_name(str(tmp_path / "f450.toml"))
    assert (airframe.name, airframe.drone_class) == ("f450", "medium")
    assert airframe.vehicle == str(tmp_path / "f450.toml")
    plant = Plant(build_world(empty_scene(), airframe), PlantCfg(seed=1, state="truth"))
    hover_enu_m = take_off(plant)
    track = come_back(plant, hover_enu_m, 2.0)
    assert np.linalg.norm(track.error_true_m[-1]) < 0.05
    assert plant.collective_thrust_fraction == pytest.approx(
        airframe.quadrotor.hover_thrust_fraction, rel=0.03
    )


def test_a_measured_curve_gives_the_constants_of_its_rotor(tmp_path):
    rotor = read(tmp_path, EXAMPLE).quadrotor.rotors[0]
    speeds_radps = np.array([3000.0, 5000.0, 7000.0, 8000.0]) * math.pi / 30.0
    thrusts_n = rotor.thrust_constant * speeds_radps**2
    np.testing.assert_allclose(thrusts_n, (1.10, 3.00, 5.95, 7.70), rtol=0.02)
    np.testing.assert_allclose(
        rotor.torque_per_thrust_m * thrusts_n, (0.018, 0.05, 0.097, 0.128), rtol=0.02
    )


def test_what_a_file_leaves_out_is_what_its_comments_say(tmp_path):
    optional = r"^(arm|leg|motor)_radius_m.*\n|^(inertia|imbalance|friction)_\w+ = \d.*\n"
    optional += r"|^(drag|rolling_moment)_coefficient.*\n|^propulsive_efficiency.*\n"
    bare = re.sub(optional, "", EXAMPLE, flags=re.MULTILINE)
    bare = bare[: bare.index("[cameras.forward]")]
    airframe, arm_m = read(tmp_path, bare), math.hypot(0.159, 0.159)
    assert airframe.arm_radius_m == pytest.approx(0.04 * arm_m)
    assert airframe.rotor_inertia_kgm2 == pytest.approx(0.0035 * 1.3 * 0.24**2 / 12.0)
    assert airframe.quadrotor.rotors[0].drag_coefficient == 0.0
    assert [mount.name for mount in airframe.cameras] == [
        "forward",
        "down",
        "up_left",
        "up_right",
        "up_rear",
    ]
    assert airframe.cameras[1].pitch_down_rad == math.pi / 2
    assert [mount.name for mount in airframe.rgbd_cameras] == ["forward", "down"]
    hover = airframe.quadrotor.hover_speed_radps
    assert airframe.rotor_imbalance_kgm == pytest.approx(0.032 / hover * 0.026)


def test_a_rotor_may_differ_from_the_others(tmp_path):
    own = 'spin = "cw"\nmax_speed_radps = 900.0\naxis = [0.0, 0.05, 1]\n'
    text = changed('spin = "cw"\n', own)
    *_, third, fourth = read(tmp_path, text).quadrotor.rotors
    assert (third.max_speed_radps, fourth.max_speed_radps) == (900.0, 838.0)
    assert math.hypot(*third.axis_flu) == pytest.approx(1.0)
    assert third.thrust_constant == fourth.thrust_constant


def test_feet_of_its_own_carry_it(tmp_path):
    feet = "feet_m = [[0.2, 0.0], [-0.15, 0.15], [-0.15, -0.15]]"
    world = build_world(empty_scene(), read(tmp_path, changed("spread_m = 0.19", feet)))
    data = world.new_data()
    mujoco.mj_forward(world.model, data)
    touching = {world.model.geom(int(max(c.geom))).name for c in data.contact}
    assert touching == {"leg0", "leg1", "leg2"}


def test_a_mesh_is_looked_at_and_touches_nothing(tmp_path):
    corners = [(0, 0, 0), (200, 0, 0), (0, 200, 0), (0, 0, 200)]
    faces = ["f 1 3 2", "f 1 2 4", "f 1 4 3", "f 2 3 4"]
    lines = [*(f"v {x} {y} {z}" for x, y, z in corners), *faces]
    (tmp_path / "body.obj").write_text("\n".join(lines))
    mesh = '\n[body.mesh]\nfile = "body.obj"\nscale = 0.001\n\n[rotor] '
    world = build_world(empty_scene(), read(tmp_path, changed("\n[rotor] ", mesh)))
    model = world.model
    geoms = np.flatnonzero(model.geom_type == mujoco.mjtGeom.mjGEOM_MESH)
    assert len(geoms) == 1
    assert not model.geom_contype[geoms].any()
    apart_m = np.linalg.norm(model.mesh_vert[:, None] - model.mesh_vert[None], axis=2)
    assert apart_m.max() == pytest.approx(0.2 * math.sqrt(2.0), rel=1e-5)


FACET = "facet normal 0 0 1\n outer loop\n{}endloop\nendfacet\n"
TETRAHEDRON = ((0, 0, 0), (200, 0, 0), (0, 200, 0), (0, 0, 200))


def ascii_stl():
    """A tetrahedron as CAD programs export it."""
    triples = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]
    facets = (
        FACET.format("".join("vertex {} {} {}\n".format(*TETRAHEDRON[i]) for i in triple))
        for triple in triples
    )
    return f"solid body\n{''.join(facets)}endsolid body\n"


def test_a_mesh_in_ascii_stl_is_the_same_as_in_obj(tmp_path):
    (tmp_path / "body.stl").write_text(ascii_stl())
    mesh = '\n[body.mesh]\nfile = "body.stl"\nscale = 0.001\n\n[rotor] '
    world = build_world(empty_scene(), read(tmp_path, changed("\n[rotor] ", mesh)))
    apart_m = np.linalg.norm(world.model.mesh_vert[:, None] - world.model.mesh_vert[None], axis=2)
    assert world.model.nmeshface == 4
    assert apart_m.max() == pytest.approx(0.2 * math.sqrt(2.0), rel=1e-5)


@pytest.mark.parametrize(
    ("name", "content", "fault"),
    [
        ("m.obj", b"", "at least 4 vertices required"),
        ("m.stl", b"", "is empty"),
        ("m.stl", bytes(80) + b"\4\0\0\0" + bytes(70), "has wrong size"),
        ("m.stl", b"solid x\nfacet normal 0 0 1", "it is no ASCII STL"),
        ("m.stl", FACET.format("vertex a b c\n").encode(), "valid: a whole STL or OBJ file"),
        (
            "m.obj",
            b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 9\n",
            "vertex index 8 does not exist",
        ),
        ("m.stl", ascii_stl().encode(), "it reaches 2"),
    ],
)
def test_a_damaged_mesh_is_one_line(tmp_path, name, content, fault):
    (tmp_path / name).write_bytes(content)
    mesh = f'\n[body.mesh]\nfile = "{name}"\n\n[rotor] '
    with pytest.raises(AirframeError, match=r"body\.mesh\.file is") as refused:
        read(tmp_path, changed("\n[rotor] ", mesh))
    assert fault in str(refused.value)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("before", "after", "fault"),
    [
        ("mass_kg = 1.3", "mass_kg = -1", "body.mass_kg is -1; valid: 0.005 to 200 kg"),
        ("mass_kg = 1.3", "", "body.mass_kg is missing; valid: 0.005 to 200 kg"),
        ("mass_kg = 1.3", "mass_g = 1300", "body.mass_kg is missing"),
        ("mass_kg = 1.3", "mass_kg = 1.3\ncolour = 1", "body.colour is unknown; valid: model"),
        ("mass_kg = 1.3", "mass_kg = nan", "body.mass_kg is nan; valid"),
        ("mass_kg = 1.3", "mass_kg = true", "body.mass_kg is True; valid"),
        ("mass_kg = 1.3", "mass_kg = 3.0", "rotors cannot be flown: rotor 1 needs .* N in hover"),
        ("[0.0118, 0.0118, 0.0210]", "[11.8, 11.8, 21.0]", "body.inertia_kgm2 is .* kg m.2"),
        ("0.0118, 0.0210", "0.0118, 0.0310", "0.031 exceeds the sum of the others; valid: up to"),
        ('name = "f450"', 'name = "a/b"', "name is 'a/b'; valid: letters, digits"),
        ('spin = "cw"\n', 'spin = "left"\n', r"rotors\[3\].spin is 'left'; valid: ccw or cw"),
        ("[0.159, 0.159, 0.03]", "[0.1, 0.2]", r"rotors\[3\].position_m is .*; valid: 3 numbers"),
        ("[0.159, 0.159, 0.03]", "[0.16, -0.1, 0.03]", r"rotors\[3\].position_m is .* beside rot"),
        (
            "[5000.0, 3.00, 0.0500]",
            "[5000.0, 5.0, 0.05]",
            "rotor.curve_rpm_n_nm has the row .* thru",
        ),
        (
            "time_constant_up_s = 0.02 ",
            "time_constant_up_s = 2.0 ",
            "rotor.time_constant_up_s is 2.0",
        ),
        (
            "spread_m = 0.19",
            "spread_m = 0.02",
            "legs.spread_m leaves the centre of mass .* valid: a",
        ),
        ("[legs]", "[skids]", "skids.height_m is missing; valid"),
        ("cells = 3", "cells = 3.5", "battery.cells is 3.5; valid: a whole number from 1 to 24"),
        ("ohm = 0.03", "ohm = 0.9", "battery.internal_resistance_ohm is 0.9, which leaves too lit"),
        ("[0.03, 0.0, -0.052]", "[0.0, 0.0, -0.3]", "cameras.down.position_m is .* above the grou"),
        (
            "[cameras.down]",
            "[cameras.left]",
            "cameras.left is unknown; valid: forward, down, up_left, up_right, up_rear",
        ),
        ("[battery]", "[batery]", "battery.cells is missing"),
        ("[body]", '[body]\nmesh = {file = "no.stl"}', "body.mesh.file is .*; valid: an existing"),
        ("radius_m = 0.12\n", "radius_m = 0.9\n", "rotors.* is .* beside rotors"),
    ],
)
def test_a_fault_is_one_line_with_file_field_value_and_a_valid_one(tmp_path, before, after, fault):
    with pytest.raises(AirframeError, match=fault) as caught:
        read(tmp_path, changed(before, after))
    line = str(caught.value)
    assert line.startswith(f"airframe '{tmp_path}/my_drone.toml': ")
    assert "valid" in line
    assert "\n" not in line


def test_a_file_that_is_none_is_named(tmp_path):
    with pytest.raises(AirframeError, match=r"gone.toml': No such file"):
        read_airframe(tmp_path / "gone.toml")
    with pytest.raises(AirframeError, match="is no TOML"):
        read(tmp_path, "name = ")


def test_three_rotors_are_told_what_they_lack(tmp_path):
    last = EXAMPLE.rindex("[[rotors]]")
    text = EXAMPLE[:last] + EXAMPLE[EXAMPLE.index("[legs]") :]
    with pytest.raises(AirframeError, match="rotors cannot be flown: 3 rotors do not control coll"):
        read(tmp_path, text)


def test_an_own_vehicle_idles_before_it_flies(tmp_path):
    plant = Plant(build_world(empty_scene(), read(tmp_path, EXAMPLE)), PlantCfg(seed=1))
    plant.align()
    plant.apply(IDLE)
    for _ in range(20):
        plant.advance()
    assert len(plant.rotor_speeds_radps) == 4
    assert min(plant.rotor_speeds_radps) > 0.0
