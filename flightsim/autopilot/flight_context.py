"""State shared by all flight behaviours: the vehicle, its references and its limits.

Behaviours come and go with the modes. The references stay here, so that the next behaviour takes
over position, velocity and acceleration of the last one without a jump.
"""

from __future__ import annotations

from math import atan2, hypot, radians

from aeroscene.scene import Relief
from autonomy.types import NAN3, ZERO3, ControlLevel, Setpoint, Vector3
from flightsim.autopilot.collision_prevention import CollisionPrevention
from flightsim.autopilot.events import EventLog, Severity
from flightsim.autopilot.fence import FenceStore, RallyStore
from flightsim.autopilot.flight_limits import FlightLimits
from flightsim.autopilot.heading import HeadingMotion, wrap_angle
from flightsim.autopilot.land_detector import LandDetector
from flightsim.autopilot.mission import MissionStore
from flightsim.autopilot.parameters import Parameters
from flightsim.autopilot.status import Home
from flightsim.autopilot.streams import OffboardStream, StickStream, TargetStream
from flightsim.autopilot.trajectory import PathMotion
from flightsim.autopilot.vehicle import TICK_S, Vehicle
from flightsim.frames import LocalFrame

# Sum of the three axes' distances between reference and vehicle. Up to the first the reference runs
# at full pace; at the second it stands still; beyond the third it starts anew at the vehicle.
_LAG_FREE_M = 0.5
_LAG_STOP_M = 1.5
_LAG_RESET_M = 5.0
_MIN_BEARING_DISTANCE_M = 1.0  # nearer than this, the direction to a place is noise
_USABLE_MPS = 1.5
"""Standard deviation of the velocity up to which a descent brakes by it. Beyond that a descent is
level, and the wind carries the vehicle along."""


class FlightContext:
    """State and means of flight that outlive a single behaviour.

    Attributes:
        path: Position reference of automatic flight.
        heading: Yaw reference.
        limits: Limits of the references.
        target_enu_m: Position that the vehicle flies to, for reports.
        terrain: Map of the terrain's height that the vehicle carries; None if it has none.
    """

    def __init__(
        self, vehicle: Vehicle, parameters: Parameters, events: EventLog, frame: LocalFrame
    ) -> None:
        self.vehicle = vehicle
        self.parameters = parameters
        self.events = events
        self.frame = frame
        self.home: Home | None = None
        self.mission = MissionStore()
        self.fence = FenceStore(frame, self._report_rally)
        self.rally = RallyStore(frame, self._report_rally)
        self.sticks = StickStream(parameters)
        self.offboard = OffboardStream()
        self.follow_target = TargetStream()
        self.landing_target = TargetStream()
        self.collision_prevention = CollisionPrevention(parameters)
        self.land_detector = LandDetector(parameters)
        self.path = PathMotion()
        self.heading = HeadingMotion()
        self.limits = FlightLimits(parameters)
        self.target_enu_m: Vector3 | None = None
        self.terrain: Relief | None = None

    @property
    def home_m(self) -> float:
        """ENU height of home, m; 0 before there is a home."""
        return 0.0 if self.home is None else self.home.position_enu_m[2]

    def terrain_m(self, east_m: float, north_m: float) -> float:
        """Return the ENU height of the terrain at a place.

        Args:
            east_m: East of the scene's origin.
            north_m: North of the scene's origin.

        Returns:
            Height in metres; that of home without a map of the terrain.
        """
        if self.terrain is None:
            return self.home_m
        return float(self.terrain.height_m(east_m, north_m))

    def move_home(self, position_enu_m: Vector3 | None, *, is_manual: bool = True) -> None:
        """Set home to a position, or to the vehicle's.

        Args:
            position_enu_m: The position; None takes the vehicle's estimate.
            is_manual: True if a client asks for it, so that arming keeps this home.
        """
        position = self.vehicle.position_enu_m if position_enu_m is None else position_enu_m
        self.home = Home(
            position_enu_m=position,
            geodetic=self.frame.geodetic_from_enu(position),
            yaw_rad=self.vehicle.yaw_rad,
            is_manual=is_manual,
        )

    def _report_rally(self) -> None:
        """Warn of rally points that a return will not use, when they or the fence have changed."""
        height_m = self.vehicle.position_enu_m[2]
        for number, (east_m, north_m) in enumerate(self.rally.points_enu_m):
            if not self.fence.allows((east_m, north_m, height_m)):
                text = f"Rally point {number} is outside the geofence, not used"
                self.events.report(Severity.WARNING, text)

    def start_references_here(self) -> None:
        """Reset the references to the vehicle, at rest if it is landed."""
        vehicle = self.vehicle
        velocity = ZERO3 if vehicle.is_landed else vehicle.velocity_enu_mps
        self.path.reset(vehicle.position_enu_m, velocity)
        self.heading.reset(vehicle.yaw_rad)

    def follow_path(self) -> Setpoint:
        """Advance the references by one tick and return them as a setpoint.

        The reference waits for a vehicle that lags, and restarts at one that is far away.
        """
        path = self.path
        (px, py, pz), (x, y, z) = path.position_enu_m, self.vehicle.position_enu_m
        lag_m = abs(px - x) + abs(py - y) + abs(pz - z)
        pace = 1.0
        if lag_m > _LAG_FREE_M:
            if lag_m > _LAG_RESET_M:
                self._restart_path()
            else:
                pace = max(0.0, (_LAG_STOP_M - lag_m) / (_LAG_STOP_M - _LAG_FREE_M))
        if pace > 0.0:
            path.step(TICK_S * pace)
        self.turn()
        if pace >= 1.0:
            return self._setpoint(
                path.position_enu_m,
                path.velocity_enu_mps,
                path.acceleration_enu_mps2,
                path.jerk_enu_mps3,
            )
        vx, vy, vz = path.velocity_enu_mps
        ax, ay, az = path.acceleration_enu_mps2
        # Time runs slower by `pace`: a velocity scales with it, an acceleration with its square.
        square = pace * pace
        return self._setpoint(
            path.position_enu_m,
            (vx * pace, vy * pace, vz * pace),
            (ax * square, ay * square, az * square),
            ZERO3,
        )

    def follow(self, position: Vector3, velocity: Vector3, acceleration: Vector3) -> Setpoint:
        """Return the setpoint of a reference other than the path, which continues from there.

        The heading is not advanced; `turn` does that.

        Args:
            position: Position, ENU m.
            velocity: Its derivative, m/s.
            acceleration: The derivative of that, m/s^2.
        """
        self.path.reset(position, velocity, acceleration)
        return self._setpoint(position, velocity, acceleration, ZERO3)

    def sink(self, speed_mps: float, place_enu_m: tuple[float, float] | None = None) -> Setpoint:
        """Return the setpoint of a level descent, onto a place or without any position.

        Unlike the path, it does not wait for a vehicle that lags.

        Args:
            speed_mps: Speed downwards.
            place_enu_m: East and north to hold; None holds no position, so that the wind carries
                the vehicle.
        """
        self.turn()
        east_m, north_m = place_enu_m or NAN3[:2]
        return Setpoint(
            level=ControlLevel.TRAJECTORY,
            position_enu_m=(east_m, north_m, NAN3[2]),
            # NaN leaves a component to the controller: no vertical position, no horizontal
            # velocity.
            velocity_enu_mps=(NAN3[0], NAN3[0], -speed_mps),
            acceleration_enu_mps2=ZERO3,
            yaw_rad=self.heading.yaw_rad,
            yaw_rate_radps=self.heading.yaw_rate_radps,
        )

    def sink_without_position(self, speed_mps: float) -> Setpoint:
        """Return the setpoint of a descent that brakes to rest by the velocity alone.

        The place is the present estimate in every tick. Without a measured position the estimate
        drifts and jumps by metres, and a vehicle that follows it is thrown about. Once the velocity
        is unknown as well, the descent is level.

        Args:
            speed_mps: Speed downwards.
        """
        # Negated, so that a deviation that is not a number counts as unknown.
        if not self.vehicle.velocity_sigma_mps <= _USABLE_MPS:
            return self.sink(speed_mps)
        self.turn()
        velocity = (0.0, 0.0, -speed_mps)
        return self._setpoint(self.vehicle.position_enu_m, velocity, ZERO3, ZERO3)

    def turn(self) -> None:
        """Advance the yaw reference by one tick, within MPC_YAWRAUTO_MAX and MPC_YAWRAUTO_ACC."""
        p = self.parameters
        self.heading.step(TICK_S, radians(p["MPC_YAWRAUTO_MAX"]), radians(p["MPC_YAWRAUTO_ACC"]))

    def face(self, target_enu_m: Vector3) -> None:
        """Turn as MPC_YAW_MODE demands for a flight to a target, unless the target is near.

        Args:
            target_enu_m: The target. 0 faces it, 1 faces home, 2 faces away from home, 3 faces
                along the motion.
        """
        mode = self.parameters["MPC_YAW_MODE"]
        x, y, _ = self.path.position_enu_m
        if mode == 3:
            dx, dy, _ = self.path.velocity_enu_mps
            least = 0.5  # m/s: below it the direction of motion is noise
        elif mode == 0 or self.home is None:
            dx, dy = target_enu_m[0] - x, target_enu_m[1] - y
            least = _MIN_BEARING_DISTANCE_M
        else:
            dx, dy = self.home.position_enu_m[0] - x, self.home.position_enu_m[1] - y
            dx, dy = (dx, dy) if mode == 1 else (-dx, -dy)
            least = _MIN_BEARING_DISTANCE_M
        if hypot(dx, dy) > least:
            self.heading.goal_yaw_rad = wrap_angle(atan2(dy, dx))

    def _setpoint(
        self, position: Vector3, velocity: Vector3, acceleration: Vector3, jerk: Vector3
    ) -> Setpoint:
        return Setpoint(
            level=ControlLevel.TRAJECTORY,
            position_enu_m=position,
            velocity_enu_mps=velocity,
            acceleration_enu_mps2=acceleration,
            jerk_enu_mps3=jerk,
            yaw_rad=self.heading.yaw_rad,
            yaw_rate_radps=self.heading.yaw_rate_radps,
        )

    def _restart_path(self) -> None:
        goal_enu_m = self.path.goal_enu_m
        self.path.reset(self.vehicle.position_enu_m, self.vehicle.velocity_enu_mps)
        self.path.fly_to(goal_enu_m, self.limits.automatic)
