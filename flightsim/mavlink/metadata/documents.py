"""Component metadata: documents on parameters and events, which clients read by file transfer.

https://mavlink.io/en/services/component_metadata.html, with the schemas of mavlink/mavlink.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from typing import Any

from flightsim.autopilot.parameters import PARAMETER_SPECS, ParameterSpec
from flightsim.mavlink.crc32 import crc32
from flightsim.mavlink.dialect import layout
from flightsim.mavlink.metadata.events import EventService, events_document
from flightsim.mavlink.service import Handler, Partners
from flightsim.mavlink.view import VehicleView

_COMPONENT_METADATA = layout("COMPONENT_METADATA")

_GENERAL = "metadata/general.json"
_OTHERS = {1: "metadata/parameters.json", 4: "metadata/events.json"}
"""Path of each further document, by its COMP_METADATA_TYPE."""
_NO_BOUND = 2**31 - 1
"""Bound that says nothing: it is the end of the parameter's type."""


class MetadataService:
    """The documents of a vehicle, the message that announces them, and the events themselves.

    Attributes:
        files: Documents by path.
        handlers: Handler of each message.
        producers: Packing function of each message of its own.
    """

    def __init__(self, view: VehicleView, partners: Partners) -> None:
        self._view = view
        self._events = EventService(view, partners)
        self.handlers: Mapping[str, Handler] = self._events.handlers
        contents = {1: _parameters_document(), 4: events_document()}
        self.files: dict[str, bytes] = {
            _OTHERS[kind]: _as_bytes(content) for kind, content in contents.items()
        }
        # Last, because it holds the checksums of the others.
        self.files[_GENERAL] = _as_bytes(self._general_document())
        self.producers: Mapping[str, Callable[[], bytes]] = {
            "COMPONENT_METADATA": self._location,
            **self._events.producers,
        }

    def update(self) -> None:
        """Report the events of a tick; call it once in each."""
        self._events.update()

    def _general_document(self) -> Mapping[str, Any]:
        return {
            "version": 1,
            "metadataTypes": [
                {"type": kind, "uri": _uri(path), "fileCrc": crc32(self.files[path])}
                for kind, path in _OTHERS.items()
            ],
        }

    def _location(self) -> bytes:
        return _COMPONENT_METADATA.encode(
            time_boot_ms=self._view.time_boot_ms,
            file_crc=crc32(self.files[_GENERAL]),
            uri=_uri(_GENERAL),
        )


def _parameters_document() -> Mapping[str, Any]:
    return {"version": 3, "parameters": [_parameter(spec) for spec in PARAMETER_SPECS]}


def _parameter(spec: ParameterSpec) -> Mapping[str, Any]:
    bounds = {"min": spec.minimum, "max": spec.maximum}
    return {
        "name": spec.name,
        "type": "Float" if spec.type == "float" else "Int32",
        "default": spec.default,
        **{name: bound for name, bound in bounds.items() if abs(bound) < _NO_BOUND},
        **({"units": spec.unit} if spec.unit else {}),
        **({"volatile": True} if spec.is_read_only else {}),
        "group": spec.name.split("_", 1)[0],
        "shortDesc": spec.description,
    }


def _uri(path: str) -> str:
    return f"mftp:///{path}"


def _as_bytes(document: Mapping[str, Any]) -> bytes:
    return json.dumps(document, separators=(",", ":")).encode()
