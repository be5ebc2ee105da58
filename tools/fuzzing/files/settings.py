"""Hostile recipes, settings of trainings, outlines and keys."""

from __future__ import annotations

from collections.abc import Iterator

from fuzzing.files.case import HERE, Case

_RECIPES: tuple[tuple[str, str], ...] = (
    ("empty-list", "start = []"),
    ("draws-billion", "draws = 1000000000"),
    ("seed-30-digits", "seed = " + "9" * 30),
    ("seed-100,000-digits", "seed = " + "9" * 100_000),
    ("brackets", "start = " + "[" * 50_000),
    ("words-many", "start = [" + '"own",' * 20_000 + "]"),
    ("turbulence-control", 'turbulence = ["\\u001b[2J"]'),
    ("traffic-billion", 'traffic = ["walkers=1000000000"]'),
    ("wind-inf", "wind_mps = [0.0, inf]"),
    ("wind-1e300", "wind_mps = [0.0, 1e300]"),
    ("time-limit-1e300", "time_limit_s = 1e300"),
    ("unknown-control", '"\\u001b[2J" = 1'),
    ("dates", "seed = 1979-05-27T07:32:00Z"),
    ("not-utf-8", "seed = 1 # \udcff"),
    ("large", "#" * (1 << 20)),
)
_TRAININGS: tuple[tuple[str, str], ...] = (
    ("brackets", "a = " + "[" * 50_000),
    ("batch-huge", "[training]\nbatch_size = 1000000000000"),
    ("section-control", '["\\u001b[2J"]\na = 1'),
    ("section-is-list", "training = [1]"),
    ("network-of-500-GB", "[model]\nwidth = 4096\nblocks = 64\nffn_ratio = 16"),
)
_OUTLINES: tuple[tuple[str, bytes], ...] = (
    ("empty", b""),
    ("nested", b"[" * 100_000),
    ("huge", b"[[0, 0], [1e300, 1e300]]"),
    ("nan", b"[[0, 0], [NaN, 1]]"),
    ("million", b"[" + b"[0,0]," * 1_500_000 + b"[1,1]]"),
    ("integer", b"[[0, 0], [" + b"9" * 100_000 + b", 1]]"),
    ("objects", b'{"a": 1}'),
)
_KEYS: tuple[tuple[str, bytes], ...] = (
    ("empty", b""),
    ("long", b"a" * (8 << 20)),
    ("lines", b"a\nb\n"),
    ("binary", bytes(range(128, 256))),
)


def settings_cases() -> Iterator[Case]:
    """Cases of recipes, settings, outlines and keys, kind by kind."""
    for name, text in _RECIPES:
        yield Case(
            kind="recipe",
            name=name,
            # A lone surrogate stands for a byte that is no UTF-8.
            files={"r.toml": text.encode(errors="surrogateescape")},
            command=("fly", "--recipe", f"{HERE}/r.toml", "--out", f"{HERE}/out", "--trial", "0"),
        )
    for name, text in _TRAININGS:
        yield Case(
            kind="settings",
            name=name,
            files={"t.toml": text.encode()},
            command=("train", "--config", f"{HERE}/t.toml", "--out", f"{HERE}/out", "--steps", "1"),
        )
    for name, content in _OUTLINES:
        yield Case(
            kind="outline",
            name=name,
            files={"o.json": content},
            command=("generate", "--outline", f"{HERE}/o.json", "--out", f"{HERE}/out"),
        )
    for name, content in _KEYS:
        yield Case(
            kind="key",
            name=name,
            files={"k.txt": content},
            command=(
                "sitl",
                "field",
                "--signing-key",
                f"{HERE}/k.txt",
                "--headless-seconds",
                "0.1",
            ),
        )
