"""Poses and velocities of a companion's odometry or motion capture, instead of the vehicle's own.

Without satellites a pose states where the vehicle is in MAVLink's local frame. With satellites, or
in a frame without a compass, it serves as odometry does: the first pose agrees with the estimate.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from autonomy.types import Quaternion, Vector3
from flightsim.autopilot.events import Severity
from flightsim.frames import euler_rpy_rad, swap_enu_ned, swap_flu_frd, swap_yaw_enu_ned
from flightsim.mavlink.channel import Channel
from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.parsing import Message
from flightsim.mavlink.service import Handler
from flightsim.mavlink.statustext import StatustextSender
from flightsim.mavlink.view import VehicleView
from flightsim.plant.external_aids import Pose, PoseUse

_SILENCE_US = 1_000_000  # silence after which poses count as lost
_FARTHEST_M, _FASTEST_MPS = 1e5, 200.0
_LEVEL, _HEIGHT, _VELOCITY, _HEADING = 1, 2, 4, 8
"""Bits of EKF2_EV_CTRL: horizontal position, height, velocity, heading."""
_NED, _FRD = mav.MAV_FRAME_LOCAL_NED, mav.MAV_FRAME_LOCAL_FRD
_BODY = (mav.MAV_FRAME_BODY_FRD, mav.MAV_FRAME_BODY_NED)
# Defaults of PX4's EKF2_EVP_NOISE, EKF2_EVV_NOISE and EKF2_EVA_NOISE, and their least values.
_USUAL_M, _USUAL_MPS, _USUAL_RAD = 0.1, 0.1, 0.1
_LEAST_M, _LEAST_MPS, _LEAST_RAD = 0.01, 0.01, 0.01
_OF_X, _OF_Y, _OF_Z, _OF_YAW = 0, 6, 11, 20
"""Indexes of the variances in the upper triangle of a 6 by 6 covariance."""
_UNKNOWN_VARIANCE = 1e4
"""Variance in m^2 or rad^2 from which on an axis counts as not measured."""
_FAILED = -1  # quality of an ODOMETRY that reports its own failure


class VisionService:
    """Passes poses and velocities of companions on to the vehicle's estimator.

    One that is not a number or out of range is dropped whole, with a text that says why.
    """

    def __init__(
        self, view: VehicleView, statustext: StatustextSender, switch: tuple[str, int]
    ) -> None:
        """Serve a vehicle.

        Args:
            view: The vehicle.
            statustext: Texts for people.
            switch: The flight stack's parameter that lets poses be used, and a value that does.
        """
        self._view = view
        self._statustext = statustext
        self._switch = switch
        self._heard_us = 0
        self._said: set[str] = set()
        self._names: set[str] = set()
        self._resets: dict[str, int] = {}
        handlers: Mapping[str, Handler] = {
            "VISION_POSITION_ESTIMATE": self._on_angles,
            "GLOBAL_VISION_POSITION_ESTIMATE": self._on_angles,
            "VICON_POSITION_ESTIMATE": self._on_angles,
            "ATT_POS_MOCAP": self._on_mocap,
            "ODOMETRY": self._on_odometry,
            "VISION_SPEED_ESTIMATE": self._on_speed,
        }
        self.handlers: Mapping[str, Handler] = {
            name: _from_companions(handler) for name, handler in handlers.items()
        }

    def update(self) -> None:
        """Notice that no poses come any more, and end their use."""
        if not self._said or self._view.time_us - self._heard_us <= _SILENCE_US:
            return
        plant, names = self._view.plant, " and ".join(sorted(self._names))
        self._said.clear()
        self._names.clear()
        self._resets.clear()
        if plant.external_aids.is_fed_poses:
            plant.external_aids.end_poses()
            has_own = plant.cfg.has("vio") or plant.cfg.has("mocap")
            rest = "the vehicle's own goes on" if has_own else "there is no other odometry"
            self._statustext.broadcast(Severity.WARNING, f"{names} lost: {rest}")

    def _on_angles(self, _: Channel, m: Message) -> None:
        covariance = getattr(m, "covariance", ())
        self._take(m, m.usec, (m.x, m.y, m.z), m.yaw, covariance)

    def _on_mocap(self, _: Channel, m: Message) -> None:
        yaw_rad = _heading_of(m.q)
        self._take(m, m.time_usec, (m.x, m.y, m.z), yaw_rad, getattr(m, "covariance", ()))

    def _on_odometry(self, _: Channel, m: Message) -> None:
        if getattr(m, "quality", 0) == _FAILED:
            self._say_once("ODOMETRY is not used: it reports that it has failed")
            return
        if m.frame_id not in {_NED, _FRD}:
            valid = f"valid are {_NED} (local NED) and {_FRD} (local FRD)"
            self._say_once(f"ODOMETRY refused: frame_id = {m.frame_id}; {valid}")
            return
        # FRD is not aligned with north: only changes of such poses can be used.
        is_relative = m.frame_id == _FRD
        position = (m.x, m.y, m.z)
        heading = _heading_of(m.q)
        self._take(m, m.time_usec, position, heading, m.pose_covariance, is_relative=is_relative)
        self._take_velocity(m)

    def _on_speed(self, _: Channel, m: Message) -> None:
        velocity = swap_enu_ned((m.x, m.y, m.z))
        covariance = getattr(m, "covariance", ())
        self._feed_velocity(m, m.usec, velocity, covariance)

    # --- poses ---

    def _take(
        self,
        m: Message,
        time_us: int,
        position_ned_m: Vector3,
        yaw_ned_rad: float,
        covariance: Sequence[float],
        *,
        is_relative: bool = False,
    ) -> None:
        """Use a pose as far as the parameter allows.

        Args:
            m: The message.
            time_us: Its time stamp.
            position_ned_m: Position in its frame.
            yaw_ned_rad: Heading; NaN if it has none.
            covariance: Upper triangle of its covariance; empty or NaN if unknown.
            is_relative: True if its frame is not aligned with north.
        """
        name, bits = m.get_type(), self._bits(m, _LEVEL | _HEIGHT | _HEADING)
        if not bits:
            return
        if not all(abs(c) <= _FARTHEST_M for c in position_ned_m):
            self._say_once(f"{name} refused: position {_listed(position_ned_m)} m")
            return
        has_heading = math.isfinite(yaw_ned_rad)
        level_m2 = _variance(covariance, (_OF_X, _OF_Y), _USUAL_M, _LEAST_M)
        height_m2 = _variance(covariance, (_OF_Z,), _USUAL_M, _LEAST_M)
        yaw_rad2 = _variance(covariance, (_OF_YAW,), _USUAL_RAD, _LEAST_RAD)
        self._watch_resets(name, getattr(m, "reset_counter", 0))
        self._feed(
            name,
            Pose(
                position_enu_m=self._view.enu_from_ned(position_ned_m),
                yaw_rad=swap_yaw_enu_ned(yaw_ned_rad) if has_heading else 0.0,
                # An infinite variance leaves this part of the pose out.
                level_variance_m2=level_m2 if bits & _LEVEL else math.inf,
                height_variance_m2=height_m2 if bits & _HEIGHT else math.inf,
                yaw_variance_rad2=yaw_rad2 if bits & _HEADING and has_heading else math.inf,
                is_relative=is_relative,
                age_s=self._view.age_s(time_us),
            ),
        )

    def _feed(self, name: str, pose: Pose) -> None:
        self._say_once(f"{name} takes the place of the vehicle's odometry")
        self._names.add(name)
        use = self._view.plant.external_aids.feed_pose(pose)
        if use is PoseUse.RESTARTED:
            self._say_once(f"Position starts anew from {name}")
        elif use is PoseUse.HEADING_REFUSED:
            self._say_once(f"Heading of {name} is not used: it differs from the compass")

    def _watch_resets(self, name: str, counter: int) -> None:
        """Begin anew if the source reports that it has jumped."""
        if self._resets.setdefault(name, counter) != counter:
            self._resets[name] = counter
            self._view.plant.external_aids.expect_jump()

    # --- velocities ---

    def _take_velocity(self, m: Message) -> None:
        """Use the velocity of ODOMETRY, in the body's frame or in the local one."""
        velocity = (m.vx, m.vy, m.vz)
        if m.child_frame_id in _BODY:
            quat = self._view.plant.estimate.quat_wxyz
            velocity_enu_mps = _rotated(quat, swap_flu_frd(velocity))
        elif m.child_frame_id == m.frame_id == _NED:
            velocity_enu_mps = swap_enu_ned(velocity)
        # A velocity in a frame without north cannot be turned into the world.
        else:
            return
        self._feed_velocity(m, m.time_usec, velocity_enu_mps, m.velocity_covariance)

    def _feed_velocity(
        self, m: Message, time_us: int, velocity_enu_mps: Vector3, covariance: Sequence[float]
    ) -> None:
        is_usable = all(abs(c) <= _FASTEST_MPS for c in velocity_enu_mps)
        if not is_usable or not self._bits(m, _VELOCITY):
            return
        self._say_once(f"{m.get_type()} gives the velocity")
        variance = _variance(covariance, (0,), _USUAL_MPS, _LEAST_MPS)
        self._view.plant.external_aids.feed_velocity(
            velocity_enu_mps, variance, self._view.age_s(time_us)
        )

    # --- what is said ---

    def _bits(self, m: Message, wanted: int) -> int:
        """Return the wanted bits that the parameter has; report once that there are none."""
        self._heard_us = self._view.time_us
        bits = int(self._view.autopilot.parameters["EKF2_EV_CTRL"])
        if not bits & wanted:
            name, value = self._switch
            self._say_once(f"{m.get_type()} is not used: {name} = {value} lets it be used")
        return bits & wanted

    def _say_once(self, text: str) -> None:
        """Queue a text once for a stream of poses."""
        if text not in self._said:
            self._said.add(text)
            self._heard_us = self._view.time_us
            self._statustext.broadcast(Severity.WARNING, text)


def _from_companions(handler: Handler) -> Handler:
    """Return a handler that skips what other vehicles report of themselves."""

    def handle(channel: Channel, message: Message) -> str | None:
        is_telemetry = message.get_srcComponent() == mav.MAV_COMP_ID_AUTOPILOT1
        return None if is_telemetry else handler(channel, message)

    return handle


def _variance(
    covariance: Sequence[float], places: Sequence[int], usual: float, least: float
) -> float:
    """Return the greatest of the named variances, or the usual one without them (NaN or 0).

    Infinite for an axis that is as good as unknown: it is not used at all.
    """
    named = [covariance[place] for place in places if place < len(covariance)]
    if not named or not all(math.isfinite(value) and value > 0.0 for value in named):
        return usual * usual
    # A better accuracy than that would make the filter follow each pose.
    variance = max(*named, least * least)
    return variance if variance < _UNKNOWN_VARIANCE else math.inf


def _heading_of(quat_wxyz: Sequence[float]) -> float:
    """Return the heading of an attitude, clockwise from its frame's x; NaN if it is none."""
    length = math.hypot(*quat_wxyz)
    if not 0.5 < length < 2.0:
        return math.nan
    w, x, y, z = (c / length for c in quat_wxyz)
    return euler_rpy_rad((w, x, y, z))[2]


def _rotated(quat_wxyz: Quaternion, vector: Vector3) -> Vector3:
    """Return a vector turned from the body's frame into the world's."""
    w, x, y, z = quat_wxyz
    a, b, c = vector
    # v + 2 w (q x v) + 2 q x (q x v), with t = 2 q x v.
    tx, ty, tz = 2.0 * (y * c - z * b), 2.0 * (z * a - x * c), 2.0 * (x * b - y * a)
    return (
        a + w * tx + y * tz - z * ty,
        b + w * ty + z * tx - x * tz,
        c + w * tz + x * ty - y * tx,
    )


def _listed(vector: Vector3) -> str:
    return ", ".join(f"{c:g}" for c in vector)
