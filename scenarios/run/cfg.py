"""What a run of the testbench is asked for."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Literal

from flightsim.testbench import TestbenchCfg, TestbenchError

MAX_CAMERA_HZ = 50.0
"""A frame for every tick of the loop."""


@dataclass(frozen=True, kw_only=True)
class SitlCfg:
    """A flight-stack testbench: a scene, a quadrotor in it, an autopilot that speaks MAVLink.

    Ground stations connect at UDP 14550, SDKs at UDP 14540 (udpin://0.0.0.0:14540), scripts also at
    TCP 5760. Ctrl-C ends the run and closes the recording.
    """

    scene: str = "42"
    """Scene of the dataset by number, a scene file (.json, .json.gz), or one of a file of layouts
    (.jsonl, .jsonl.gz) as FILE#ID or FILE#N."""
    bench: TestbenchCfg = field(default_factory=TestbenchCfg)
    demo: bool = False
    """Fly our own mission: plan to a landing area, navigate, choose the touchdown point from
    depth, land, disarm; then print the verdict and end."""
    map: Literal["truth", "onboard"] = "truth"
    """What our mission knows of the place: truth is the scene's own map; onboard is nothing but the
    flight volume and the areas, and the map grows from depth."""
    target: Literal["landing", "perching", "any"] = "landing"
    """What our mission lands on: a landing area, a place to perch on, or the best of both."""
    record: Path | None = None
    """Write a rerun recording to this .rrd file."""
    pictures: Path | None = None
    """Draw what was planned and flown, and the landing map, into this folder when the run ends."""
    viewer: Literal["off", "web", "native"] = "off"
    """Watch live: web serves on loopback, native opens the rerun viewer."""
    camera_hz: float = 5.0
    """Frames a simulated second of each camera while recording or watching; 0 turns them off."""
    headless_seconds: float | None = None
    """End after this many simulated seconds."""
    json: bool = False
    """Print one JSON object on standard output when the run ends, and nothing else there."""

    def __post_init__(self) -> None:
        """Refuse what cannot be run, before anything starts."""
        if not 0 <= self.camera_hz <= MAX_CAMERA_HZ:
            raise TestbenchError(
                f"camera-hz {self.camera_hz} is out of range; valid: 0 to {MAX_CAMERA_HZ:.0f} Hz"
            )
        if self.headless_seconds is not None and not self.headless_seconds > 0:
            raise TestbenchError(
                f"headless-seconds {self.headless_seconds} is not positive; valid: seconds above 0"
            )
        if self.record is not None and self.record.suffix != ".rrd":
            raise TestbenchError(f"record {str(self.record)!r} is no .rrd file; valid: NAME.rrd")
        if self.pictures is not None and self.pictures.exists() and not self.pictures.is_dir():
            raise TestbenchError(f"pictures {str(self.pictures)!r} is a file; valid: a folder")

    def to_plain(self) -> dict[str, Any]:
        """The resolved configuration as plain data."""
        plain = asdict(self)
        paths = {"record": self.record, "pictures": self.pictures}
        return plain | {name: None if path is None else str(path) for name, path in paths.items()}
