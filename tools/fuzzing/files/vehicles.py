"""Hostile airframes, bodies, meshes and lidars."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from importlib import resources

from fuzzing.files.case import HERE, Case

# A valid file with one hostile value reaches deeper than one that is wrong throughout.
_IRIS = resources.files("flightsim.vehicles").joinpath("shipped/iris.toml").read_text()
_LIDAR = resources.files("flightsim.lidars").joinpath("shipped/vlp16.toml").read_text()
_TOML: tuple[tuple[str, str], ...] = (
    ("empty", ""),
    ("brackets", "a = " + "[" * 50_000),
    ("dots", "a" + ".a" * 50_000 + " = 1"),
    ("tables", "".join(f"[t{i}]\n" for i in range(20_000))),
    ("inline-tables", "a = " + "{a = " * 20_000),
    ("integer", "a = " + "9" * 100_000),
    ("control", 'title = "\\u001b[2J"'),
    ("not-toml", "\x00\x1b[31m = ="),
    ("large", "#" * (4 << 20)),
)
_AIRFRAME: tuple[tuple[str, str, str], ...] = (
    ("name-control", 'name = "iris"', 'name = "\\u001b[2J"'),
    ("name-path", 'name = "iris"', 'name = "../../x"'),
    ("title-control", 'title = "3DR Iris', 'title = "\\u001b]0;x\\u0007Iris'),
    ("title-reversed", 'title = "3DR Iris', 'title = "\\u202eIris'),
    ("mass-huge", "mass_kg = 1.535", "mass_kg = 1e300"),
    ("mass-integer", "mass_kg = 1.535", "mass_kg = 1" + "0" * 400),
    ("mass-nan", "mass_kg = 1.535", "mass_kg = nan"),
    ("size-list", "size_m = [0.22, 0.11, 0.07]", "size_m = [" + "0.1, " * 20_000 + "]"),
    ("rotor-speed", "max_speed_radps = 1100.0", "max_speed_radps = inf"),
    ("cells", "cells = 3", "cells = 1000000000"),
    ("unknown-control", "cells = 3", '"c\\u001b[2J" = 3'),
    ("feet-many", "spread_m = 0.20", "feet_m = [" + "[0.1, 0.1], " * 15_000 + "]"),
    ("rotors-many", "[legs]", "[[rotors]]\nspin = 'cw'\n" * 5_000 + "[legs]"),
)


def vehicle_cases() -> Iterator[Case]:
    """Cases of airframes, then of the files that they name, then of lidars."""
    for name, text in _TOML:
        yield _airframe(name, text)
        yield _lidar(name, text)
    for name, before, after in _AIRFRAME:
        # A shipped file that changed would make the case an honest one.
        assert before in _IRIS
        yield _airframe(name, _IRIS.replace(before, after, 1))
    for name, content in _meshes():
        suffix = name.rpartition(".")[2]
        yield _with_body(f"mesh-{name}", f"mesh = {{file = 'm.{suffix}'}}", f"m.{suffix}", content)
    yield _with_body("mesh-device", "mesh = {file = '/dev/zero.obj'}", "m.obj", b"")
    yield _with_body("mesh-of-the-system", "mesh = {file = '/etc/passwd'}", "m.obj", b"")
    for name, content in _bodies():
        suffix = name.rpartition(".")[2]
        yield _with_body(f"body-{name}", f"model = {{file = 'b.{suffix}'}}", f"b.{suffix}", content)
    for name, before, after in (
        ("beams", "beams = 16", "beams = 1000000"),
        ("step", "step_deg = 0.2", "step_deg = 1e-300"),
        ("range", "range_m = [0.4, 100.0]", "range_m = [0.4, 1e300]"),
        ("shots", "[spinning]", "[rosette]\nshots_hz = 999999999999\n[spinning]"),
    ):
        yield _lidar(name, _LIDAR.replace(before, after))
    head = "azimuth_deg,elevation_deg\n"
    for name, text in (
        ("csv-empty", ""),
        ("csv-control", "\x1b[2J"),
        ("csv-huge", head + "1e300,0\n"),
        ("csv-long", head + "1," * 1_000_000),
        ("csv-million-shots", head + "1,1\n" * 1_500_000),
        ("csv-20-MB", head + "1.00000,1.00000\n" * 1_300_000),
        ("csv-quotes", head + '"' * 300_000),
    ):
        yield _lidar(name, text, "l.csv")


def _airframe(name: str, text: str) -> Case:
    return Case(
        kind="airframe",
        name=name,
        files={"v.toml": text.encode()},
        command=("export", "--scene", "field", "--vehicle", f"{HERE}/v.toml", *_OUT),
    )


def _with_body(name: str, line: str, file: str, content: bytes) -> Case:
    airframe = _IRIS.replace("[body]", f"[body]\n{line}", 1).encode()
    return Case(
        kind="mesh" if name.startswith("mesh") else "body",
        name=name,
        files={"v.toml": airframe, file: content},
        command=("export", "--scene", "field", "--vehicle", f"{HERE}/v.toml", *_OUT),
    )


_OUT = ("--to", "mjcf", "--out", f"{HERE}/out")


def _lidar(name: str, text: str, file: str = "l.toml") -> Case:
    return Case(
        kind="lidar",
        name=f"lidar-{name}",
        files={file: text.encode(errors="surrogatepass")},
        command=("sitl", "field", "--lidar", f"{HERE}/{file}", "--headless-seconds", "0.1"),
    )


def _meshes() -> Iterator[tuple[str, bytes]]:
    corners = "v 0 0 0\nv .1 0 0\nv 0 .1 0\nv 0 0 .1\n"
    faces = "f 1 2 3\nf 1 2 4\nf 1 3 4\nf 2 3 4\n"
    facet = "facet normal 0 0 1\nouter loop\n{}endloop\nendfacet\n"
    triangle = facet.format("vertex 0 0 0\nvertex .1 0 0\nvertex 0 .1 .05\n")
    yield "empty.obj", b""
    yield "empty.stl", b""
    # Binary STL: 80 bytes of header, the number of triangles, and 50 bytes for each.
    yield "cut-short.stl", bytes(80) + (4).to_bytes(4, "little") + bytes(70)
    yield "zeros.stl", bytes(80) + (4).to_bytes(4, "little") + bytes(200)
    yield "claims-billions.stl", bytes(80) + (2**32 - 1).to_bytes(4, "little") + bytes(5000)
    yield (
        "nan.stl",
        bytes(80) + b"\4\0\0\0" + (struct.pack("<12f", *[float("nan")] * 12) + b"\0\0") * 4,
    )
    yield "ascii.stl", f"solid x\n{triangle * 4}endsolid x\n".encode()
    yield "ascii-cut-short.stl", f"solid x\n{triangle}facet normal 0".encode()
    yield "ascii-words.stl", f"solid x\n{facet.format('vertex a b c' * 3)}endsolid".encode()
    yield "ascii-nan.stl", f"solid x\n{triangle.replace('.05', 'nan')}endsolid x\n".encode()
    yield "ascii-huge.stl", f"solid x\n{triangle.replace('.05', '1e300')}endsolid x\n".encode()
    yield "ascii-30-MB.stl", f"solid x\n{triangle * 300_000}endsolid x\n".encode()
    yield "binary.obj", bytes(range(256)) * 1000
    yield "no-faces.obj", corners.encode()
    yield "index-beyond.obj", (corners + "f 1 2 999999999\n").encode()
    yield "index-negative.obj", (corners + "f -1 -2 -300\n").encode()
    yield "huge-vertices.obj", (corners.replace(".1", "1e300") + faces).encode()
    yield "kilometres.obj", (corners.replace(".1", "1000") + faces).encode()
    yield "material-elsewhere.obj", ("mtllib /dev/zero\n" + corners + faces).encode()
    yield "polygon.obj", (corners + "f " + "1 2 3 4 " * 200_000).encode()
    yield "40-MB.obj", (corners * 1_000_000 + faces).encode()


def _bodies() -> Iterator[tuple[str, bytes]]:
    # Ten of the entity before in each: 10 to the power of 11 words, in a kilobyte.
    lol = "".join(f'<!ENTITY l{i} "{f"&l{i - 1};" * 10}">' for i in range(1, 12))
    box = '<geom type="box" size=".1 .1 .1" mass="1.5"/>'
    yield "empty.urdf", b""
    yield "not-xml.xml", b"\x1b[2J<"
    yield (
        "laughs.urdf",
        f'<!DOCTYPE r [<!ENTITY l0 "lol">{lol}]><robot name="&l11;"/>'.encode(),
    )
    yield (
        "file-entity.urdf",
        b'<!DOCTYPE r [<!ENTITY x SYSTEM "file:///etc/passwd">]><robot name="&x;"/>',
    )
    yield "nested.urdf", b"<robot>" * 100_000
    yield "nested.xml", b"<mujoco><worldbody>" + b"<body>" * 30_000
    yield "include-itself.xml", b'<mujoco><include file="b.xml"/></mujoco>'
    yield "include-passwd.xml", b'<mujoco><include file="/etc/passwd"/></mujoco>'
    yield "mesh-missing.xml", b'<mujoco><asset><mesh name="m" file="none.stl"/></asset></mujoco>'
    yield "no-body.xml", b"<mujoco><worldbody/></mujoco>"
    yield (
        "size-nan.xml",
        _body(box.replace(".1 .1 .1", "nan 1 1")),
    )
    yield (
        "mass-huge.xml",
        _body(box.replace("1.5", "1e300")),
    )
    yield (
        "plugin.xml",
        b'<mujoco><extension><plugin plugin="mujoco.elasticity.cable"/></extension></mujoco>',
    )
    yield (
        "boxes-many.xml",
        f"<mujoco><worldbody><body>{box * 60_000}</body></worldbody></mujoco>".encode(),
    )
    yield "name-control.xml", b'<mujoco model="\x1b[2J"/>'
    yield (
        "texture-huge.xml",
        (
            b'<mujoco><asset><texture name="t" type="2d" builtin="flat" width="60000" '
            b'height="60000"/></asset></mujoco>'
        ),
    )
    yield (
        "replicate.xml",
        _body(f'<replicate count="100000000">{box}</replicate>'),
    )


def _body(shapes: str) -> bytes:
    return f"<mujoco><worldbody><body>{shapes}</body></worldbody></mujoco>".encode()
