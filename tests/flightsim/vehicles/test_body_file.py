"""Bodies from URDF and MJCF files: what is read, flown and hit, and what is refused."""

import math
import re
from pathlib import Path

import mujoco
import numpy as np
import pytest

from flightsim.plant import Plant, PlantCfg
from flightsim.vehicles.airframe import AirframeError
from flightsim.vehicles.body_file import read_body_file
from flightsim.vehicles.definition import read_airframe
from flightsim.world import build_world
from scenarios.bench.figure_eight import come_back, take_off
from tests.flightsim.handmade import empty_scene

PAGE = Path(__file__).parents[3] / "docs" / "airframes.md"
EXAMPLE = re.search(r"```toml\n(.*?)```", PAGE.read_text(), re.DOTALL)[1]
WITHOUT_MASS = re.sub(r"^(mass_kg|inertia_kgm2) = .*\n", "", EXAMPLE, flags=re.MULTILINE)

# Two links of 1 kg and .3 kg: the centre of mass is at (0, 0, 0.02) of the base.
URDF = """
<robot name="two">
  <material name="red"><color rgba="0.8 0.1 0.1 1"/></material>
  <link name="base">
    <inertial><origin xyz="0 0 0.0377"/><mass value="1.0"/>
      <inertia ixx="0.011" ixy="0" ixz="0" iyy="0.011" iyz="0" izz="0.02"/></inertial>
    <visual><origin xyz="0 0 0.02"/><geometry><mesh filename="package://two/hull.obj"/></geometry>
      <material name="red"/></visual>
    <collision><origin xyz="0 0 0.02"/><geometry><box size="0.2 0.3 0.1"/></geometry></collision>
  </link>
  <link name="pod">
    <inertial><mass value="0.3"/>
      <inertia ixx="0.0002" ixy="0" ixz="0" iyy="0.0002" iyz="0" izz="0.0002"/></inertial>
    <visual><geometry><sphere radius="0.03"/></geometry></visual>
  </link>
  <joint name="tilt" type="revolute"><parent link="base"/><child link="pod"/>
    <origin xyz="0 0 -0.039"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
</robot>
"""
HULL = """
v -0.1 -0.1 0
v 0.1 -0.1 0
v 0 0.1 0
v 0 0 0.1
f 1 3 2
f 1 2 4
f 2 3 4
f 3 1 4
"""
# A box that spins on a post turned by 90 degrees to the left; no masses.
MJCF = """
<mujoco>
  <asset><material name="blue" rgba="0 0 1 1"/></asset>
  <worldbody>
    <geom type="plane" size="1 1 1"/>
    <body name="post" pos="0 0 3" quat="0.7071068 0 0 0.7071068">
      <freejoint/>
      <geom type="cylinder" size="0.05 0.03" contype="0" conaffinity="0" material="blue"/>
      <body pos="0.1 0 0"><joint name="spin" axis="0 0 1"/><geom type="box" size="0.1 0.02 0.01"/>
      </body>
    </body>
  </worldbody>
  <actuator><motor joint="spin"/></actuator>
  <keyframe><key qpos="0 0 1 1 0 0 0 0.5"/></keyframe>
</mujoco>
"""


def read(folder, text, *, model=URDF, name="body.urdf", more=""):
    """The airframe of the documented example whose body is in another file."""
    (folder / "hull.obj").write_text(HULL)
    (folder / name).write_text(model)
    path, table = folder / "mine.toml", f'[body.model]\nfile = "{name}"\n{more}\n'
    path.write_text(text.replace("\n[rotor]", f"\n{table}\n[rotor]", 1))
    return read_airframe(path)


def geoms(world, *names):
    """Numbers of the geoms whose names begin so."""
    return [i for i in range(world.model.ngeom) if world.model.geom(i).name.startswith(names)]


def test_mass_centre_and_inertia_are_those_of_all_links(tmp_path):
    airframe = read(tmp_path, WITHOUT_MASS)
    assert airframe.quadrotor.mass_kg == pytest.approx(1.3)
    assert airframe.model.position_flu_m == pytest.approx((0.0, 0.0, -0.02))
    level_kgm2 = 0.011 + 0.0002 + 1.0 * 0.0177**2 + 0.3 * 0.059**2
    expected = (level_kgm2, level_kgm2, 0.0202)
    assert airframe.quadrotor.inertia_flu_kgm2 == pytest.approx(expected, rel=1e-3)


def test_the_vehicle_looks_as_the_file_and_touches_as_its_fuselage(tmp_path):
    world = build_world(empty_scene(), read(tmp_path, WITHOUT_MASS))
    mesh, pod = geoms(world, "vehicle/look")
    assert world.model.geom_type[mesh] == mujoco.mjtGeom.mjGEOM_MESH
    assert world.model.geom_rgba[mesh] == pytest.approx((0.8, 0.1, 0.1, 1.0))
    assert world.model.geom_pos[pod] == pytest.approx((0.0, 0.0, -0.059))
    assert not world.model.geom_contype[[mesh, pod]].any()
    (fuselage,) = geoms(world, "fuselage")
    assert world.model.geom_size[fuselage] == pytest.approx((0.08, 0.06, 0.04))


def test_what_the_file_lets_touch_hits_things_where_that_is_asked_for(tmp_path):
    world = build_world(empty_scene(), read(tmp_path, WITHOUT_MASS, more="hits_things = true"))
    (solid,) = geoms(world, "fuselage")
    assert world.model.geom_size[solid] == pytest.approx((0.1, 0.15, 0.05))
    data = world.new_data()
    data.qpos[3:7] = (math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0)  # on its left side
    data.qpos[2] = 0.14
    mujoco.mj_forward(world.model, data)
    touching = {int(max(contact.geom)) for contact in data.contact}
    assert solid in touching


def test_solid_meshes_bump_into_another_vehicle(tmp_path):
    solid = URDF.replace("<collision>", "<collision name='hull'>").replace(
        '<box size="0.2 0.3 0.1"/>', '<mesh filename="hull.obj"/>'
    )
    airframe = read(tmp_path, WITHOUT_MASS, model=solid, more="hits_things = true")
    world = build_world(empty_scene(), airframe, airframe)
    bumpers = geoms(world, "bumper", "vehicle_2/bumper")
    kinds = world.model.geom_type[bumpers]
    assert np.count_nonzero(kinds == mujoco.mjtGeom.mjGEOM_MESH) == 2


def test_a_vehicle_with_a_body_from_a_file_flies(tmp_path):
    airframe = read(tmp_path, WITHOUT_MASS, more="hits_things = true")
    plant = Plant(build_world(empty_scene(), airframe), PlantCfg(seed=1, state="truth"))
    track = come_back(plant, take_off(plant), 2.0)
    assert np.linalg.norm(track.error_true_m[-1]) < 0.05


def test_mjcf_counts_where_its_body_rests_without_its_world_and_joints(tmp_path):
    airframe = read(tmp_path, EXAMPLE, model=MJCF, name="body.xml")
    assert airframe.quadrotor.mass_kg == 1.3
    content = read_body_file(Path(airframe.model.path))
    assert content.mass is None
    post, arm = content.parts
    assert (post.is_solid, arm.is_solid) == (False, True)
    assert post.rgba == (0.0, 0.0, 1.0, 1.0)
    assert arm.position_m == pytest.approx((0.1, 0.0, 0.0))
    np.testing.assert_allclose(arm.corners_m.max(axis=0), (0.2, 0.02, 0.01), atol=1e-6)


REFUSED = {
    "body.mass_kg is 1.5, but the file of model says 1.3; valid: that, or no mass_kg": (
        EXAMPLE.replace("mass_kg = 1.3", "mass_kg = 1.5"),
        URDF,
        "",
    ),
    r"body.inertia_kgm2 is \[0.0118, 0.0118, 0.021\], but .* says \[0.01256, 0.01256, 0.0202\]; "
    "valid: that, or no inertia_kgm2": (EXAMPLE, URDF, ""),
    r"body.model.position_m is \[0.0, 0.0, 0.0\], .*; valid: \[-?0.0, -?0.0, -0.02\]": (
        WITHOUT_MASS,
        URDF,
        "position_m = [0.0, 0.0, 0.0]",
    ),
    r"body.model has a file with a product of inertia of 0.002 kg m\^2; valid: up to 0.00063": (
        WITHOUT_MASS,
        URDF.replace('ixz="0" iyy="0.011"', 'ixz="0.002" iyy="0.011"'),
        "",
    ),
    "body.model has a file with a mass of 900.3 kg; valid: 0.005 to 200 kg": (
        WITHOUT_MASS,
        URDF.replace('value="1.0"', 'value="900"'),
        "",
    ),
    "body.model has a solid box that reaches 1 m aside and 0.05 m down; valid: 0.345 m": (
        WITHOUT_MASS,
        URDF.replace("0.2 0.3 0.1", "0.2 2 0.1"),
        "hits_things = true",
    ),
    "body.model has a solid box that reaches 0.18 m aside and 0.15 m down; .* less than 0.12": (
        WITHOUT_MASS,
        URDF.replace("0.2 0.3 0.1", "0.2 0.3 0.3"),
        "hits_things = true",
    ),
    "body.model.hits_things is true, but nothing in body.urdf touches things; valid: false": (
        WITHOUT_MASS,
        re.sub("<collision>.*</collision>", "", URDF),
        "hits_things = true",
    ),
    "body.model.file is '.*': .*no.obj": (WITHOUT_MASS, URDF.replace("hull.obj", "no.obj"), ""),
    "body.model.file is '.*body.urdf': unclosed token": (WITHOUT_MASS, "<robot", ""),
    "body.model.file is '.*': its topmost element is 'mujoco'": (WITHOUT_MASS, "<mujoco/>", ""),
    "body.model.hits_things is 1; valid: true or false": (WITHOUT_MASS, URDF, "hits_things = 1"),
    "body.model.colour is unknown; valid: file, ": (WITHOUT_MASS, URDF, "colour = 1"),
    "body.model stands beside mesh; valid: one of the two": (
        EXAMPLE.replace("# [body.mesh]", "[body.mesh]"),
        URDF,
        "",
    ),
}


@pytest.mark.parametrize("fault", REFUSED)
def test_a_body_that_does_not_fit_is_refused_by_its_field(tmp_path, fault):
    text, model, more = REFUSED[fault]
    with pytest.raises(AirframeError, match=f"airframe '.*mine.toml': {fault}") as refusal:
        read(tmp_path, text, model=model, more=more)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize(
    ("inside", "fault"),
    [
        ("", "it has 0 bodies in its world; one is valid"),
        ("<body/>", "its body has no shape"),
        ('<body><geom size="1"/></body>' * 2, "it has 2 bodies in its world; one is valid"),
        ("<nonsense/>", "nonsense"),
    ],
)
def test_mjcf_that_is_no_body_is_refused(tmp_path, inside, fault):
    model = f"<mujoco><worldbody>{inside}</worldbody></mujoco>"
    with pytest.raises(AirframeError, match=rf"body.model.file is '.*body.xml': .*{fault}"):
        read(tmp_path, EXAMPLE, model=model, name="body.xml")


def test_a_file_that_is_missing_or_of_another_kind_is_refused(tmp_path):
    for name in ("missing.urdf", "body.stl"):
        text = EXAMPLE.replace("\n[rotor]", f'\n[body.model]\nfile = "{name}"\n\n[rotor]', 1)
        (tmp_path / "mine.toml").write_text(text)
        (tmp_path / "body.stl").write_text("")
        with pytest.raises(AirframeError, match=r"valid: an existing file, \.urdf or \.xml"):
            read_airframe(tmp_path / "mine.toml")
