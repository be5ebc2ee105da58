"""Blueprint of a recording in the viewer: scene large, cameras beside it, plots and texts below.

A blueprint is rerun's name for the arrangement of views. It travels in the recording, so that every
viewer opens with start and goal in sight, without any settings of the user's.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np
import rerun.blueprint as rrb

from aeroscene.scene import Scene
from autonomy.types import Vector3
from flightsim.cameras.framing import frame_points
from flightsim.vehicles.airframe import Airframe
from scenarios.recording import layout

_SKY_RGB = (158, 184, 208)
_EYE_AZIMUTH_RAD = math.radians(-125.0)
_EYE_ELEVATION_RAD = math.radians(38.0)
_EYE_FOV_RAD = math.radians(55.0)
"""Vertical angle of view of rerun's eye."""
_VIEW_ASPECT = 1.6  # assumed width over height of the scene's view
_ROOM_M = 4.0
"""Margin shown around start and goal, and above them."""
_MARGIN = 1.05
_FLAT = (layout.camera_depth, layout.camera_classes, layout.camera_instances)
"""Images of a camera that the view of the scene leaves out."""
_KEPT = (layout.EXECUTED, layout.EARLIER_PLANS, layout.CHOICES, layout.CONTACTS)
"""Entities that stay visible from their first row up to the time cursor."""
SWITCHED_OFF = (layout.LANDING_SLOPE, layout.LANDING_ROUGHNESS, layout.LANDING_CLEARANCE)
"""Layers of the landing map that would cover its safety; the user switches them on."""


def recording_blueprint(
    scene: Scene,
    airframe: Airframe,
    goal_enu_m: Vector3 | None = None,
    *,
    has_segments: bool = False,
    other_vehicles: Mapping[str, Airframe] = MappingProxyType({}),
) -> rrb.Blueprint:
    """Return the blueprint of a recording of a run.

    Args:
        scene: Scene of the flight.
        airframe: Vehicle that flies.
        goal_enu_m: Goal, framed together with the start; None frames the whole scene.
        has_segments: True if camera frames have objects and classes.
        other_vehicles: Other vehicles in the same world, by their names, such as `vehicle_2`.
    """
    cameras = [mount.name for mount in airframe.rgbd_cameras]
    shown = _Shown(tuple(cameras), other_vehicles)
    return rrb.Blueprint(
        rrb.Horizontal(
            rrb.Vertical(_scene_views(scene, shown, goal_enu_m), _plots(), row_shares=[5, 3]),
            rrb.Vertical(
                _camera_views(cameras, has_segments=has_segments),
                *_states(),
                _texts(),
                row_shares=[10, 2.6, 5, 5],
            ),
            column_shares=[3, 2],
        ),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        rrb.TimePanel(state="collapsed", timeline=layout.TIMELINE),
    )


def scene_blueprint(scene: Scene) -> rrb.Blueprint:
    """Return the blueprint of a scene without a flight: one view and the legend."""
    return rrb.Blueprint(
        rrb.Horizontal(
            _scene_view("Scene", _Shown(), _overview(scene, None)),
            _legend(),
            column_shares=[5, 1],
        ),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        rrb.TimePanel(state="hidden"),
    )


@dataclass(frozen=True)
class _Shown:
    """Entities of all vehicles that a view of the world treats specially."""

    cameras: tuple[str, ...] = ()
    other_vehicles: Mapping[str, Airframe] = field(default_factory=dict)

    @property
    def images(self) -> list[str]:
        """Images of depth and segments of all vehicles, which have views of their own."""
        own = [image(camera) for camera in self.cameras for image in _FLAT]
        return own + [
            layout.of_vehicle(name, image(mount.name))
            for name, airframe in self.other_vehicles.items()
            for mount in airframe.rgbd_cameras
            for image in _FLAT
        ]

    def of_all(self, *entities: str) -> list[str]:
        """Return entities of the first vehicle, and the same entities of the others."""
        others = (
            layout.of_vehicle(name, each) for name in self.other_vehicles for each in entities
        )
        return [*entities, *others]


def _scene_views(scene: Scene, shown: _Shown, goal_enu_m: Vector3 | None) -> rrb.Container:
    # The eye looks through the camera that follows the vehicle.
    chase = rrb.EyeControls3D(tracking_entity=layout.CHASE)
    return rrb.Tabs(
        _scene_view("Scene", shown, _overview(scene, goal_enu_m)),
        _scene_view("Chase", shown, chase),
        active_tab=0,
    )


def _scene_view(name: str, shown: _Shown, eye: rrb.EyeControls3D) -> rrb.Spatial3DView:
    # Without this range, only the newest row of an entity would be visible.
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
        contents=["+ $origin/**", *(f"- {image}" for image in shown.images)],
        background=_SKY_RGB,
        line_grid=False,
        eye_controls=eye,
        overrides={
            **dict.fromkeys(shown.of_all(*_KEPT), until_now),
            **dict.fromkeys(shown.of_all(*SWITCHED_OFF), rrb.EntityBehavior(visible=False)),
        },
    )


def _overview(scene: Scene, goal_enu_m: Vector3 | None) -> rrb.EyeControls3D:
    """Return an eye from above one side, on start and goal side by side or on the whole scene."""
    low, high = np.array(scene.extent_min_enu_m), np.array(scene.extent_max_enu_m)
    # The ground alone is framed: the flight volume's height would push the eye away.
    high[2] = low[2]
    azimuth_rad = _EYE_AZIMUTH_RAD
    if goal_enu_m is not None:
        ends = np.array([scene.start_position_enu_m, goal_enu_m])
        low, high = ends.min(axis=0) - (_ROOM_M, _ROOM_M, 0.0), ends.max(axis=0) + _ROOM_M
        # Seen from either side, start and goal lie beside each other. The side nearer to the usual
        # azimuth is taken, so that recordings of a scene look alike.
        x, y, _ = (ends[1] - ends[0]).tolist()
        sides = [math.atan2(y, x) + turn for turn in (-math.pi / 2, math.pi / 2)]
        azimuth_rad = max(sides, key=lambda side: math.cos(side - _EYE_AZIMUTH_RAD))
    corners = np.array(list(itertools.product(*zip(low.tolist(), high.tolist(), strict=True))))
    eye, target = frame_points(
        corners,
        azimuth_rad=azimuth_rad,
        elevation_rad=_EYE_ELEVATION_RAD,
        vertical_fov_rad=_EYE_FOV_RAD,
        aspect=_VIEW_ASPECT,
        margin=_MARGIN,
    )
    return rrb.EyeControls3D(position=eye, look_target=target, eye_up=(0.0, 0.0, 1.0))


def _camera_views(cameras: Sequence[str], *, has_segments: bool) -> rrb.Container:
    kinds = [("colour", layout.camera_rgb), ("depth", layout.camera_depth)]
    if has_segments:
        kinds += [("classes", layout.camera_classes), ("objects", layout.camera_instances)]
    views = [
        rrb.Spatial2DView(
            name=f"{camera} {what}",
            origin=layout.camera(camera),
            contents=[layout.camera(camera), images(camera)],
        )
        for camera in cameras
        for what, images in kinds
    ]
    return rrb.Grid(*views, grid_columns=2)


def _plots() -> rrb.Container:
    errors = (layout.POSITION_ERROR, f"{layout.POSITION_SIGMA}/**")
    return rrb.Tabs(
        _axis_plots("position", "m"),
        _axis_plots("velocity", "m/s"),
        rrb.Horizontal(
            _plot("Position", *errors), _plot("Attitude", layout.ATTITUDE_ERROR), name="Errors"
        ),
        rrb.Horizontal(
            _plot("Accelerometer", layout.ACCELERATION),
            _plot("Gyroscope", layout.ANGULAR_RATE),
            rrb.TimeSeriesView(
                name="Gauges",
                origin="/",
                contents=[f"+ /{layout.sensor('**')}", f"- /{layout.IMU}/**"],
            ),
            name="Sensors",
        ),
        rrb.Horizontal(
            _plot("Motors", layout.MOTOR_COMMAND, layout.MOTOR_SPEED),
            _plot("Battery", layout.BATTERY_VOLTAGE, layout.BATTERY_CURRENT),
            name="Power",
        ),
        _plot("Wind", layout.WIND),
        active_tab=0,
    )


def _plot(name: str, *entities: str) -> rrb.TimeSeriesView:
    return rrb.TimeSeriesView(name=name, origin="/", contents=[f"+ /{e}" for e in entities])


def _axis_plots(what: str, unit: str) -> rrb.Container:
    """Return a plot for each axis, with the true, the estimated and the reference value."""
    plots = [
        rrb.TimeSeriesView(name=f"{axis}, {unit}", origin=f"{layout.STATE}/{what}/{axis}")
        for axis in layout.AXES
    ]
    return rrb.Horizontal(*plots, name=what.capitalize())


def _states() -> tuple[rrb.View, rrb.View]:
    """Return two views of states, because rerun sorts rows and the pilot's phase must be first."""
    states = [layout.MODE, layout.ARMED, layout.LANDED, layout.FAILSAFE]
    return (
        rrb.StateTimelineView(name="Pilot", origin="/", contents=[f"+ /{layout.PHASE}"]),
        rrb.StateTimelineView(
            name="Mode and state", origin="/", contents=[f"+ /{state}" for state in states]
        ),
    )


def _legend() -> rrb.View:
    return rrb.Spatial2DView(name="Legend", origin=layout.LEGEND, contents=[layout.LEGEND])


def _texts() -> rrb.Container:
    columns = rrb.TextLogColumns(
        timeline_columns=[layout.TIMELINE], text_log_columns=["loglevel", "body"]
    )
    return rrb.Tabs(
        rrb.TextLogView(name="Messages", origin=layout.STATUSTEXT, columns=columns),
        _legend(),
        rrb.TextLogView(name="Contacts", origin=layout.TOUCHED, columns=columns),
        rrb.TextDocumentView(name="Run", origin=layout.RUN),
        active_tab=0,
    )
