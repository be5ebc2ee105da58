"""Configuration of a run of the testbench.

The docstring of each field is its text in `--help`, so it holds unit, range and default.
"""

from __future__ import annotations

import os
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Annotated, Any, Literal

import tyro

from aeroscene.ranges import Range, require_ranges
from flightsim.testbench import MAX_INSTANCES, TestbenchCfg, TestbenchError
from flightsim.vehicles import Airframe, airframe_by_name
from scenarios.run.levels import RecordLevel

MAX_CAMERA_HZ = 50.0
"""Greatest frame rate: one frame for every tick of the loop."""
MAX_DOMAIN = 232
"""Greatest number of a DDS domain whose ports exist."""
_UNSET = tyro.conf.arg(help_behavior_hint="")


@dataclass(frozen=True, kw_only=True)
class SitlCfg:
    """Configuration of a run: scene, testbench, mission, and outputs."""

    scene: str = "42"
    """Scene of the dataset by number, corpus:N, gen:SEED, district:SEED, field (open, flat), a
    scene file (.json, .json.gz), one of a file of layouts (FILE.jsonl#ID or #N), or a place on a
    map (FILE.osm#W,S,E,N in degrees, also .osm.gz, .osm.pbf and .geojson)."""
    bench: TestbenchCfg = field(default_factory=TestbenchCfg)
    vehicles: Annotated[str, _UNSET] = ""
    """Fly several vehicles in one world: their number, or airframes such as iris,hummingbird. The
    first stands on the start, the others beside it; vehicle i is instance i. One by default."""
    demo: bool = False
    """Fly our own mission: plan to a landing area, navigate, choose the touchdown point from
    depth, land, disarm; then print the verdict and end."""
    start: Annotated[str | None, _UNSET] = None
    """Place of the vehicle at first: area:ID, or x,y,z (east, north, up in m; --start=-3,2,0) on a
    surface; by default the scene's own start."""
    area: Annotated[int | None, Range(0), _UNSET] = None
    """Number of the area to land on; by default the seed draws one among all that fit the vehicle
    and can be flown to, indoors and outdoors with equal chance."""
    goal: Literal["area", "words", "naming", "relation", "chain"] = "area"
    """How the pilot learns where to land: area names the area; words is a text that fits one place
    of the scene alone, and naming, relation or chain is its grade, see docs/goals.md. With --area,
    the text means the place of that area."""
    map: Literal["truth", "onboard"] = "truth"
    """Knowledge that our mission has of the place: truth is the scene's own map; onboard is nothing
    but the flight volume and the areas, and the map grows from depth."""
    planner: Literal["optimise", "primitives"] = "optimise"
    """Planner of our mission's trajectories: optimise is our optimiser; primitives are motion
    primitives after Mueller, Hehn and D'Andrea (2015)."""
    target: Literal["landing", "perching", "any"] = "landing"
    """Kind of place that our mission lands on: a landing area, a place to perch on, or the best of
    both."""
    record: Annotated[Path | None, _UNSET] = None
    """Write a rerun recording to this .rrd file; its folder is made if only that is missing."""
    record_level: RecordLevel = "full"
    """Contents of the recording and the viewer: summary is verdict, trajectories, contacts and
    texts; state is all but camera images; interaction adds depth from when the vehicle is above its
    area."""
    pictures: Annotated[Path | None, _UNSET] = None
    """Draw the planned and the flown path, and the landing map, into this folder when the run ends;
    it is made if only that is missing."""
    formats: Annotated[tuple[Literal["png", "svg", "pdf"], ...], tyro.conf.arg(name="format")] = (
        "png",
    )
    """Formats of the pictures; several may be named."""
    captures: Annotated[Path | None, _UNSET] = None
    """Write the photographs and films that clients and missions take with the gimbal's camera to
    this folder; it is made if only that is missing. Without it none is kept."""
    video: bool = False
    """Stream the images of the gimbal's camera as H.264 by RTP to UDP port 5600 of this machine,
    plus the instance; needs PyAV (pip install 'aeroscene[video]')."""
    ros2: bool = False
    """Publish the run as topics and transforms of ROS 2, and take commands from nodes; needs no
    ROS here (pip install 'aeroscene[ros2]'), see docs/ros2.md."""
    ros2_transport: Literal["dds", "zenoh"] = "dds"
    """Transport of ROS 2's messages: dds is for rmw_fastrtps, the default, and rmw_cyclonedds;
    zenoh for rmw_zenoh."""
    ros2_domain: Annotated[int | None, Range(0, MAX_DOMAIN), _UNSET] = None
    """Domain of ROS 2; by default the value of ROS_DOMAIN_ID, or 0."""
    airsim: bool = False
    """Answer the API of AirSim's multirotors, so that scripts for AirSim fly here; see
    docs/clients/airsim.md."""
    airsim_port: Annotated[int, Range(0, 65535)] = 41451
    """TCP port of AirSim's API; 0 takes any that is free."""
    airsim_settings: Annotated[Path | None, _UNSET] = None
    """Take vehicles, their places, cameras and sensors, clock speed and wind from AirSim's
    settings.json; turns --airsim on."""
    viewer: Literal["off", "web", "native"] = "off"
    """Watch live: web serves a page on loopback, native opens the rerun viewer. Either stays after
    the flight, until it is closed or Ctrl-C."""
    camera_hz: Annotated[float, Range(0.0, MAX_CAMERA_HZ, "Hz")] = 5.0
    """Frames of each camera in a simulated second, while recording or watching."""
    headless_seconds: Annotated[float | None, Range(0.0, unit="s", is_above=True), _UNSET] = None
    """End after this many simulated seconds, even in flight."""
    navigation_limit_s: Annotated[float | None, Range(0.0, unit="s", is_above=True), _UNSET] = None
    """Seconds after lift-off in which the vehicle must have come above its area; the verdict is
    too_slow after that."""
    json: bool = False
    """Print one JSON object on standard output when the run ends, and nothing else there."""

    def __post_init__(self) -> None:
        """Refuse invalid settings before anything starts.

        Raises:
            TestbenchError: Naming the option, its value and what would be valid.
        """
        # Reading the property checks it.
        _ = self.airframes
        require_ranges(self, TestbenchError)
        if self.record is not None and self.record.suffix != ".rrd":
            raise TestbenchError(f"record {str(self.record)!r} is no .rrd file; valid: NAME.rrd")
        if self.record is not None:
            _require_folder("record", self.record.parent)
        if self.pictures is not None:
            _require_folder("pictures", self.pictures)
        if self.captures is not None:
            _require_folder("captures", self.captures)
        if self.ros2:
            _ = self.domain
        if self.goal != "area" and len(self.airframes) > 1:
            raise TestbenchError(
                f"goal {self.goal!r} is one vehicle's, vehicles {self.vehicles!r} are several; "
                "valid: one vehicle, or --goal area"
            )
        if not self.formats:
            raise TestbenchError("format has no value; valid: png, svg, pdf")

    @property
    def domain(self) -> int:
        """Domain of ROS 2.

        Raises:
            TestbenchError: If it comes from ROS_DOMAIN_ID and is no domain.
        """
        if self.ros2_domain is not None:
            return self.ros2_domain
        said = os.environ.get("ROS_DOMAIN_ID") or "0"
        if not said.isdecimal() or int(said) > MAX_DOMAIN:
            raise TestbenchError(f"ROS_DOMAIN_ID {said!r} is no domain; valid: 0 to {MAX_DOMAIN}")
        return int(said)

    @property
    def airframes(self) -> tuple[Airframe, ...]:
        """Airframe of each vehicle, the first one first.

        Raises:
            TestbenchError: If the number of vehicles is not valid.
            AirframeError: If there is no such airframe.
        """
        # A number means so many of the configured airframe, anything else is a list of airframes.
        names = self.vehicles.split(",") if self.vehicles else [self.bench.vehicle]
        if self.vehicles.lstrip("-").isdecimal():
            # Capped, so that a huge number makes no huge list before it is refused.
            names = [self.bench.vehicle] * min(max(int(self.vehicles), 0), MAX_INSTANCES + 1)
        if not 1 <= len(names) <= MAX_INSTANCES or not all(names):
            raise TestbenchError(
                f"vehicles {self.vehicles!r} is not valid; valid: 1 to {MAX_INSTANCES}, or "
                "airframes with commas between them, such as iris,hummingbird"
            )
        return tuple(airframe_by_name(name.strip()) for name in names)

    def to_plain(self) -> dict[str, Any]:
        """Return the resolved configuration as plain data."""
        plain = asdict(self)
        # A recording names the light that it was made in, also where the seed drew it.
        plain["bench"]["light"] = str(self.bench.weather)
        paths = {"record": self.record, "pictures": self.pictures, "captures": self.captures}
        return plain | {name: None if path is None else str(path) for name, path in paths.items()}


def _require_folder(name: str, folder: Path) -> None:
    """Refuse a folder that cannot be written to, nor be made in one that can."""
    # A missing folder is created later, so its parent must exist.
    there = folder if folder.exists() else folder.parent
    if not there.is_dir():
        what = "is a file" if there.exists() else "is not there"
        raise TestbenchError(f"{name}: {str(there)!r} {what}; valid: a folder that exists")
    if not os.access(there, os.W_OK | os.X_OK):
        raise TestbenchError(f"{name}: {str(there)!r} may not be written to")
