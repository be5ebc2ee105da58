"""The story of a flight, read from its recording alone.

Scene and airframe are in the recording, so pictures can be drawn whatever has become of their
files. The figures equal those of a `tape.FlightTape`, except that layers of the landing map are
those of the last whole second and of half precision.
"""

from __future__ import annotations

from pathlib import Path

import msgspec
import numpy as np
from jaxtyping import Float

from aeroscene.scene import InteractionArea, Scene
from aeroscene.scene.io import scene_from_json
from autonomy.types import Vector3, vector3
from flightsim.vehicles.airframe import Airframe
from flightsim.vehicles.catalogue import airframe_by_name
from scenarios.pictures.story import (
    FlightStory,
    LandingLayers,
    MoverPath,
    PictureError,
    PlannedLeg,
    Track,
    title_of,
)
from scenarios.recording import layout
from scenarios.recording.rows import RecordedRows
from scenarios.recording.summary import facts_of, readable

_WANTED = (
    f"{layout.STATE}/position",
    layout.ARMED,
    layout.PHASE,
    layout.PLANNED,
    layout.LANDING_GRID,
    layout.TOUCHDOWN,
    layout.TRAFFIC,
    layout.SCENE_DOCUMENT,
)
_SCALARS = "Scalars:scalars"


def read_story(path: Path) -> FlightStory:
    """Read the story of a flight from its recording.

    Args:
        path: File of a recording, also of a run that was killed.

    Raises:
        UnreadableRecordingError: If the file is missing or no recording.
        PictureError: If it holds no scene or no flight.
    """
    with readable(path) as source:
        rows = RecordedRows(source, _WANTED)
    scene, airframe = read_scene(rows, path), read_airframe(rows, path)
    verdict = facts_of(rows.properties.get(layout.VERDICT_PROPERTY, {}), "figures", path)
    track = _track(rows)
    if len(track.time_s) == 0:
        raise PictureError(f"recording {str(path)!r} holds no flight; valid: one that flew")
    return FlightStory(
        scene=scene,
        airframe=airframe,
        title=title_of(scene, airframe, verdict.get("reason", "not ended")),
        track=track,
        phases=tuple((t * 1e-6, row[0]) for t, row in rows.rows(layout.PHASE, "StateChange:state")),
        plans=_plans(rows),
        movers=_movers(rows),
        area=_area(scene, verdict.get("area")),
        touchdown_enu_m=_touchdown(rows),
        landing=_landing(rows),
    )


def read_scene(rows: RecordedRows, path: Path) -> Scene:
    """Read the scene of the flight.

    Args:
        rows: Rows of the recording, with `layout.SCENE_DOCUMENT`.
        path: File of the recording, for the error.

    Raises:
        PictureError: If the recording holds none.
    """
    found = rows.rows(layout.SCENE_DOCUMENT, "json")
    if not found:
        raise PictureError(
            f"recording {str(path)!r} holds no scene; valid: one of aeroscene sitl --record"
        )
    return scene_from_json(found[-1][1][0], source=str(path))


def read_airframe(rows: RecordedRows, path: Path) -> Airframe:
    """Read the airframe of the flight.

    Args:
        rows: Rows of the recording, with its properties.
        path: File of the recording, for the error.

    Raises:
        PictureError: If the recording names no airframe, or a damaged one.
    """
    run = rows.properties.get(layout.RUN_PROPERTY, {})
    if "airframe" in run:
        try:
            return msgspec.json.decode(run["airframe"], type=Airframe)
        except (msgspec.DecodeError, TypeError) as error:
            raise PictureError(
                f"recording {str(path)!r} holds a damaged airframe ({error}); valid: one that was "
                "written whole"
            ) from None
    if "vehicle" not in run:
        raise PictureError(f"recording {str(path)!r} names no vehicle; valid: one of a flight")
    return airframe_by_name(run["vehicle"])  # Recordings of older versions have the name alone.


def _track(rows: RecordedRows) -> Track:
    axes = [rows.vectors(layout.state("position", axis), _SCALARS) for axis in layout.AXES]
    # A truncated file may lack the last rows of one axis.
    n = min(len(values) for _, values in axes)
    time_us = axes[0][0]
    ref_m, est_m, true_m = np.stack([values[:n] for _, values in axes], axis=2).swapaxes(0, 1)
    # States are recorded when they change, so each holds until the next one.
    is_armed = np.zeros(n, dtype=bool)
    for since_us, state in rows.rows(layout.ARMED, "StateChange:state"):
        is_armed[time_us[:n] >= since_us] = state[0] == "armed"
    return Track(
        time_s=time_us[:n] * 1e-6,
        true_enu_m=true_m,
        est_enu_m=est_m,
        ref_enu_m=np.where(is_armed[:, None], ref_m, np.nan),
    )


def _plans(rows: RecordedRows) -> tuple[PlannedLeg, ...]:
    """Return the plans from arming on, because earlier ones were not flown."""
    durations_s = dict(rows.rows(layout.PLANNED, "duration_s"))
    armed = [t for t, s in rows.rows(layout.ARMED, "StateChange:state") if s[0] == "armed"]
    begin_us = armed[0] if armed else 0
    legs: list[PlannedLeg] = []
    for time_us, strips in rows.rows(layout.PLANNED, "LineStrips3D:strips"):
        points = np.array(strips[0], dtype=float)
        if time_us not in durations_s:
            continue
        # Of the plans before arming only the last one was taken up, when the rotors began to turn.
        if time_us <= begin_us:
            legs.clear()
        legs.append(
            PlannedLeg(
                time_s=max(time_us, begin_us) * 1e-6,
                points_enu_m=points,
                step_s=durations_s[time_us][0] / max(1, len(points) - 1),
            )
        )
    return tuple(legs)


def _movers(rows: RecordedRows) -> tuple[MoverPath, ...]:
    paths = []
    for entity in rows.entities:
        if entity.startswith(f"{layout.TRAFFIC}/"):
            _, points = rows.vectors(entity, "Transform3D:translation")
            name = entity.rpartition("/")[2]
            paths.append(MoverPath(name=name, points_enu_m=points.astype(float)))
    return tuple(path for path in paths if len(path.points_enu_m))


def _area(scene: Scene, area_id: int | None) -> InteractionArea | None:
    return next((area for area in scene.interaction_areas if area.id == area_id), None)


def _touchdown(rows: RecordedRows) -> Vector3 | None:
    found = rows.rows(layout.TOUCHDOWN, "Points3D:positions")
    return vector3(np.array(found[-1][1][0])) if found else None


def _landing(rows: RecordedRows) -> LandingLayers | None:
    """Return the last landing map whose layers were written, None if there is none."""
    layers = ("height_m", "slope_rad", "roughness_m", "clearance_m")
    names = ("east_m", "north_m", "is_observed", "is_safe", *layers)
    found = {name: rows.rows(layout.LANDING_GRID, name) for name in names}
    if not all(found.values()):
        return None
    last = {name: np.array(values[-1][1]) for name, values in found.items()}
    n = len(last["east_m"])
    seen = last["is_observed"].reshape(n, n)

    # Layers are recorded without the cells that were not seen.
    def spread(name: str) -> Float[np.ndarray, "n n"]:
        layer = np.full((n, n), np.nan)
        layer[seen] = last[name]
        return layer

    return LandingLayers(
        east_m=last["east_m"],
        north_m=last["north_m"],
        **{name: spread(name) for name in layers},
        is_safe=spread("is_safe") == 1.0,
    )
