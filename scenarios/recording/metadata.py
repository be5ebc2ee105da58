"""Metadata of a recording's run: properties for programs, a page for people."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

import rerun as rr

from aeroscene.scene import Scene
from aeroscene.scene.io import scene_to_json
from flightsim.vehicles.airframe import Airframe
from scenarios.recording import layout


@dataclass(frozen=True, kw_only=True)
class RunInfo:
    """Identity of the run of a recording."""

    scene: str
    vehicle: str
    seed: int
    config: Mapping[str, Any] = field(default_factory=dict)
    """The fully resolved configuration, as plain data."""
    limits: Mapping[str, float] = field(default_factory=dict)
    """Thresholds of the verdict, so that a reader of the recording can judge by them."""

    @property
    def title(self) -> str:
        """Scene, vehicle and seed in a few words."""
        return f"scene {self.scene}, {self.vehicle}, seed {self.seed}"


def log_run(stream: rr.RecordingStream, info: RunInfo, airframe: Airframe) -> None:
    """Write the identity of the run before it begins.

    Args:
        stream: Recording.
        info: Identity, configuration and limits.
        airframe: First vehicle, which is written in full, so that its file is not needed later.
    """
    stream.send_recording_name(info.title)
    stream.send_property(
        layout.RUN_PROPERTY,
        rr.AnyValues(
            scene=info.scene,
            vehicle=info.vehicle,
            airframe=json.dumps(asdict(airframe), sort_keys=True),
            seed=info.seed,
            config=json.dumps(info.config, sort_keys=True),
            limits=json.dumps(info.limits, sort_keys=True),
        ),
    )
    _log_page(stream, info, verdict=None)


def log_document(stream: rr.RecordingStream, scene: Scene) -> None:
    """Write the whole scene as a document, so that pictures can be drawn from the recording alone.

    Args:
        stream: Recording.
        scene: Scene of the flight.
    """
    document = rr.AnyValues(json=scene_to_json(scene).decode())
    stream.log(layout.SCENE_DOCUMENT, document, static=True)


def log_verdict(stream: rr.RecordingStream, info: RunInfo, verdict: Mapping[str, Any]) -> None:
    """Write the result of the run: `success`, `code`, `reason`, and all figures as JSON.

    `success` is absent if there was nothing to judge. It is not written as None, because rerun
    would write an empty list in a process that has written a truth value under that name before.

    Args:
        stream: Recording.
        info: Identity of the run, for the page that people read.
        verdict: Verdict and figures as plain data.
    """
    success = verdict.get("success")
    stream.send_property(
        layout.VERDICT_PROPERTY,
        rr.AnyValues(
            **({} if success is None else {"success": success}),
            code=str(verdict.get("code", "")),
            reason=str(verdict.get("reason", "")),
            figures=json.dumps(verdict, sort_keys=True),
        ),
    )
    _log_page(stream, info, verdict)


# Written at the start and again with the verdict: the last one of a static entity counts.
def _log_page(stream: rr.RecordingStream, info: RunInfo, verdict: Mapping[str, Any] | None) -> None:
    sections = [f"# {info.title}"]
    if verdict is not None:
        sections.append("## Verdict\n\n" + _table(verdict))
    if info.limits:
        sections.append("## Limits of the verdict\n\n" + _table(info.limits))
    if info.config:
        sections.append("## Configuration\n\n" + _table(info.config))
    page = rr.TextDocument("\n\n".join(sections), media_type=rr.MediaType.MARKDOWN)
    stream.log(layout.RUN, page, static=True)


def _table(values: Mapping[str, Any]) -> str:
    rows = [f"| {key} | {_cell(value)} |" for key, value in values.items()]
    return "\n".join(["| | |", "|---|---|", *rows])


def _cell(value: object) -> str:
    # A bar or a line break would end the cell of a Markdown table.
    text = f"{value:.4g}" if isinstance(value, float) else str(value)
    return text.replace("|", "\\|").replace("\n", " ")
