"""Hostile checkpoints and datasets, as other programs or nobody would write them."""

from __future__ import annotations

import json
from collections.abc import Iterator
from importlib import resources
from typing import Any

from fuzzing.files.case import HERE, Case

_KEY = "aeroscene"
_SHIPPED = resources.files("aeroscene.learning").joinpath("checkpoints/default.safetensors")


def weight_cases() -> Iterator[Case]:
    """Cases of checkpoints, then of folders of scenes."""
    for name, content in _checkpoints():
        yield Case(
            kind="checkpoint",
            name=name,
            files={"c.safetensors": content},
            command=("generate", "--checkpoint", f"{HERE}/c.safetensors", "--out", f"{HERE}/out"),
        )
    for name, manifest in _manifests():
        yield Case(
            kind="dataset",
            name=name,
            files={"d/manifest.json": manifest},
            command=("dataset", "stats", f"{HERE}/d", "--jobs", "1"),
        )


def _safetensors(header: Any, body: bytes = b"") -> bytes:
    text = header if isinstance(header, bytes) else json.dumps(header).encode()
    # The format: length of the header in eight bytes, header in JSON, numbers.
    return len(text).to_bytes(8, "little") + text + body


def _checkpoints() -> Iterator[tuple[str, bytes]]:
    one = {"dtype": "F32", "shape": [1], "data_offsets": [0, 4]}
    facts = {"format": "aeroscene-checkpoint", "version": 10**30, "code": "\x1b[2J"}
    yield "empty", b""
    yield "zeros", bytes(5000)
    yield "header-claims-all", b"\xff" * 8 + b"{}"
    yield "header-nested", _safetensors(b"[" * 1_000_000)
    yield "no-metadata", _safetensors({"a": one}, bytes(4))
    # A pickle that leaves the file "owned" if it is loaded.
    yield "pickle", b"\x80\x02cos\nsystem\n(S'touch {here}/owned'\ntR."
    yield (
        "metadata-nested",
        _safetensors({"__metadata__": {_KEY: "[" * 100_000}, "a": one}, bytes(4)),
    )
    yield (
        "metadata-other",
        _safetensors({"__metadata__": {_KEY: json.dumps(facts)}, "a": one}, bytes(4)),
    )
    yield (
        "metadata-bomb",
        _safetensors({"__metadata__": {_KEY: "[" + "[]," * 4_000_000 + "0]"}, "a": one}, bytes(4)),
    )
    yield (
        "weights-of-others",
        _safetensors(
            {"w": {**one, "shape": [50_000_000], "data_offsets": [0, 200_000_000]}},
            bytes(200_000_000),
        ),
    )
    yield (
        "names-many",
        _safetensors(
            {f"a{i}": {**one, "shape": [0], "data_offsets": [0, 0]} for i in range(200_000)}
        ),
    )

    data = _SHIPPED.read_bytes()
    yield "weights-cut-short", data[:-1000]
    yield "weights-changed", data[:-1000] + bytes(1000)
    huge = {"width": 4096, "blocks": 64, "ffn_ratio": 16}
    yield "network-of-150-GB", _with_configs(data, "model", huge)
    yield "writer-of-other-sizes", _with_configs(data, "writer", {"width": 1024, "ffn_ratio": 8})
    yield "section-unknown", _with_configs(data, "\x1b[2J", {})


def _with_configs(data: bytes, section: str, changes: dict[str, Any]) -> bytes:
    """A checkpoint that describes another network than the one that its weights are of."""
    n_bytes = int.from_bytes(data[:8], "little")
    header = json.loads(data[8 : 8 + n_bytes])
    facts = json.loads(header["__metadata__"][_KEY])
    facts["configs"][section] = facts["configs"].get(section, {}) | changes
    header["__metadata__"][_KEY] = json.dumps(facts)
    return _safetensors(header, data[8 + n_bytes :])


def _manifests() -> Iterator[tuple[str, bytes]]:
    head = {"format": "aeroscene-dataset", "version": 1, "scenes": []}
    yield "empty", b""
    yield "nested", b"[" * 500_000
    yield "version-huge", json.dumps(head | {"version": 10**30}).encode()
    yield "scene-elsewhere", json.dumps(head | {"scenes": [{"file": "../../etc/passwd"}]}).encode()
    yield "scenes-of-nothing", json.dumps(head | {"scenes": [{}] * 900_000}).encode()
