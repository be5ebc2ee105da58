"""How a recording opens in the viewer: scene large, cameras beside it, plots and texts below."""

from __future__ import annotations

import math
from collections.abc import Sequence

import rerun.blueprint as rrb

from aeroscene.scene import Scene
from autonomy.types import Vector3
from flightsim.vehicles.airframe import Airframe
from scenarios.recording import layout

_SKY_RGB = (158, 184, 208)
_EYE_AZIMUTH_RAD = math.radians(-125.0)
_EYE_ELEVATION_RAD = math.radians(38.0)
_EYE_DISTANCE_PER_EXTENT = 0.76
SWITCHED_OFF = (layout.LANDING_SLOPE, layout.LANDING_ROUGHNESS, layout.LANDING_CLEARANCE)
"""Layers of the landing map that lie where its safety is shown; the viewer switches them on."""
_CHASE_OFFSET_M = (-6.0, -4.0, 3.5)


def recording_blueprint(scene: Scene, airframe: Airframe) -> rrb.Blueprint:
    """The arrangement of a recording of `airframe` in `scene`."""
    cameras = [mount.name for mount in airframe.cameras]
    return rrb.Blueprint(
        rrb.Horizontal(
            rrb.Vertical(_scene_views(scene, cameras), _plots(), row_shares=[5, 3]),
            rrb.Vertical(_camera_views(cameras), _states(), _texts(), row_shares=[10, 5, 5]),
            column_shares=[3, 2],
        ),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        rrb.TimePanel(state="collapsed", timeline=layout.TIMELINE),
    )


def scene_blueprint(scene: Scene) -> rrb.Blueprint:
    """The arrangement of a scene that nobody flies in."""
    eye, target = _overview(scene)
    return rrb.Blueprint(
        _scene_view("Scene", (), eye, target, tracking=None),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        rrb.TimePanel(state="hidden"),
    )


def _scene_views(scene: Scene, cameras: Sequence[str]) -> rrb.Container:
    overview_eye, overview_target = _overview(scene)
    start = scene.start_position_enu_m
    return rrb.Tabs(
        _scene_view("Scene", cameras, overview_eye, overview_target, tracking=None),
        _scene_view(
            "Chase", cameras, _add(start, _CHASE_OFFSET_M), start, tracking=layout.FUSELAGE
        ),
        active_tab=0,
    )


def _scene_view(
    name: str, cameras: Sequence[str], eye: Vector3, target: Vector3, tracking: str | None
) -> rrb.Spatial3DView:
    until_now = rrb.VisibleTimeRanges(
        rrb.VisibleTimeRange(
            layout.TIMELINE,
            start=rrb.TimeRangeBoundary.infinite(),
            end=rrb.TimeRangeBoundary.cursor_relative(),
        )
    )
    return rrb.Spatial3DView(
        name=name,
        origin=layout.WORLD,
        contents=["+ $origin/**", *(f"- {layout.camera_depth(camera)}" for camera in cameras)],
        background=_SKY_RGB,
        line_grid=False,
        eye_controls=rrb.EyeControls3D(
            position=eye,
            look_target=target,
            eye_up=(0.0, 0.0, 1.0),
            tracking_entity=tracking,
        ),
        overrides={
            layout.EXECUTED: until_now,
            layout.EARLIER_PLANS: until_now,
            layout.CHOICES: until_now,
            **dict.fromkeys(SWITCHED_OFF, rrb.EntityBehavior(visible=False)),
        },
    )


def _overview(scene: Scene) -> tuple[Vector3, Vector3]:
    """An eye that sees the whole flight volume from above one corner, and what it looks at."""
    lower, upper = scene.extent_min_enu_m, scene.extent_max_enu_m
    target = ((lower[0] + upper[0]) / 2, (lower[1] + upper[1]) / 2, lower[2])
    distance = _EYE_DISTANCE_PER_EXTENT * math.hypot(upper[0] - lower[0], upper[1] - lower[1])
    level = distance * math.cos(_EYE_ELEVATION_RAD)
    offset = (
        level * math.cos(_EYE_AZIMUTH_RAD),
        level * math.sin(_EYE_AZIMUTH_RAD),
        distance * math.sin(_EYE_ELEVATION_RAD),
    )
    return _add(target, offset), target


def _add(a: Vector3, b: Vector3) -> Vector3:
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def _camera_views(cameras: Sequence[str]) -> rrb.Container:
    views: list[rrb.View] = []
    for camera in cameras:
        views += [
            rrb.Spatial2DView(
                name=f"{camera} colour",
                origin=layout.camera(camera),
                contents=[layout.camera(camera), layout.camera_rgb(camera)],
            ),
            rrb.Spatial2DView(
                name=f"{camera} depth",
                origin=layout.camera(camera),
                contents=[layout.camera(camera), layout.camera_depth(camera)],
            ),
        ]
    return rrb.Grid(*views, grid_columns=2)


def _plots() -> rrb.Container:
    def plot(name: str, *contents: str) -> rrb.TimeSeriesView:
        return rrb.TimeSeriesView(name=name, origin="/", contents=[f"+ /{c}" for c in contents])

    return rrb.Tabs(
        plot("Position", layout.POSITION_TRUE, layout.POSITION_EST, layout.POSITION_REF),
        plot("Velocity", layout.VELOCITY_TRUE, layout.VELOCITY_EST, layout.VELOCITY_REF),
        plot("Position error", layout.POSITION_ERROR, f"{layout.POSITION_SIGMA}/**"),
        plot("Attitude error", layout.ATTITUDE_ERROR),
        plot("Wind", layout.WIND),
        plot("Accelerometer", layout.ACCELERATION),
        plot("Gyroscope", layout.ANGULAR_RATE),
        plot("Motors", layout.MOTOR_COMMAND, layout.MOTOR_SPEED),
        plot("Battery", layout.BATTERY_VOLTAGE, layout.BATTERY_CURRENT),
        rrb.TimeSeriesView(
            name="Sensors",
            origin="/",
            contents=[f"+ /{layout.sensor('**')}", f"- /{layout.IMU}/**"],
        ),
        active_tab=0,
    )


def _states() -> rrb.View:
    states = [layout.PHASE, layout.MODE, layout.ARMED, layout.LANDED, layout.FAILSAFE]
    contents = [f"+ /{state}" for state in states]
    return rrb.StateTimelineView(name="Mode and state", origin="/", contents=contents)


def _texts() -> rrb.Container:
    columns = rrb.TextLogColumns(
        timeline_columns=[layout.TIMELINE], text_log_columns=["loglevel", "body"]
    )
    return rrb.Tabs(
        rrb.TextLogView(name="Messages", origin=layout.STATUSTEXT, columns=columns),
        rrb.TextDocumentView(name="Run", origin=layout.RUN),
        active_tab=0,
    )
