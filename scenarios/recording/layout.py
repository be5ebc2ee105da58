"""Layout of a recording: the entity path of each quantity, and the one timeline.

Writers, readers and blueprints take every path from here. The names are part of the format: pages,
exports and recordings of users refer to them, so an existing name must not change.
"""

from __future__ import annotations

APPLICATION_ID = "aeroscene"
TIMELINE = "sim_time"

WORLD = "world"
SCENE = "world/scene"
GROUND = "world/ground"
LANDING_AREAS = "world/landing_areas"
PERCHING_AREAS = "world/perching_areas"
LANDING_SAFETY = "world/landing_map/safety"
LANDING_SLOPE = "world/landing_map/slope"
LANDING_ROUGHNESS = "world/landing_map/roughness"
LANDING_CLEARANCE = "world/landing_map/clearance"
LANDING_GRID = "world/landing_map/grid"
TOUCHDOWN = "world/landing_map/touchdown"
CHOICES = "world/landing_map/choices"
CONTACTS = "world/contacts"
TRAFFIC = "world/traffic"
TRACKS = "world/tracks"
TRACK_VELOCITIES = "world/tracks/velocity"
VEHICLE = "world/vehicle"
FUSELAGE = "world/vehicle/fuselage"
ROTORS = "world/vehicle/rotors"
FRAME = "world/vehicle/frame"
MARKER = "world/vehicle/marker"
LIDAR = "world/vehicle/lidar"
CHASE = "world/chase"
ESTIMATE = "world/estimate"
PLANNED = "world/trajectory/planned"
EARLIER_PLANS = "world/trajectory/earlier"
EXECUTED = "world/trajectory/executed"

STATE = "state"
STATES = ("reference", "estimate", "true")
AXES = ("east", "north", "up")
BODY_AXES = ("forward", "left", "up")
POSITION_ERROR = "error/position"
ATTITUDE_ERROR = "error/attitude"
POSITION_SIGMA = "error/sigma"

WIND = "environment/wind"

IMU = "sensors/imu"
ACCELERATION = f"{IMU}/acceleration"
ANGULAR_RATE = f"{IMU}/angular_rate"
MOTOR_COMMAND = "motors/command"
MOTOR_SPEED = "motors/speed"
BATTERY_VOLTAGE = "battery/voltage"
BATTERY_CURRENT = "battery/current"
BATTERY_REMAINING = "battery/remaining"

OPTICAL_FLOW = "measured/optical_flow"
OPTICAL_FLOW_PARTS = (
    *("integration_us", "flow_forward_rad", "flow_right_rad"),
    *("gyro_forward_rad", "gyro_right_rad", "gyro_down_rad", "distance_m", "quality"),
)
"""Names of the columns of `OPTICAL_FLOW`, in order; axes are body FRD."""

TOUCHING = "contacts/touching"
TOUCHED = "contacts/touched"

MODE = "autopilot/mode"
ARMED = "autopilot/armed"
LANDED = "autopilot/landed_state"
FAILSAFE = "autopilot/failsafe"
STATUSTEXT = "autopilot/statustext"
PHASE = "pilot/phase"
RUN = "run"
LEGEND = "run/legend"
VERDICT = "run/verdict"
SCENE_DOCUMENT = "run/scene"

RUN_PROPERTY = "run"
VERDICT_PROPERTY = "verdict"


def of_vehicle(name: str, entity: str) -> str:
    """Return the path that an entity of the first vehicle has for another vehicle.

    For example, `world/vehicle` of `vehicle_2` is `world/vehicle_2/vehicle`, and `run` is
    `vehicle_2/run`.

    Args:
        name: Name of the vehicle, such as `vehicle_2`.
        entity: Path of the first vehicle's entity.
    """
    root, _, rest = entity.partition("/")
    return f"{WORLD}/{name}/{rest}" if root == WORLD else f"{name}/{entity}"


def sensor(name: str) -> str:
    """Return the entity of a sensor's gauge; `name` is the sensor's field in `PlantCfg`."""
    return f"sensors/{name}"


def state(what: str, axis: str) -> str:
    """Return the entity of one axis of a vector, with a column for each of `STATES`.

    Args:
        what: "position", "velocity" or "angular_rate".
        axis: One of `AXES`, or of `BODY_AXES` for the angular rate, which has no reference.
    """
    return f"{STATE}/{what}/{axis}"


def mover(name: str) -> str:
    """Return the entity of the mover `name`: a person, a car or another drone."""
    return f"{TRAFFIC}/{name}"


def camera(name: str) -> str:
    """Return the entity of the camera `name`, fixed to the vehicle; its images are below it."""
    return f"{VEHICLE}/camera_{name}"


def camera_rgb(name: str) -> str:
    """Return the entity of the colour images of a camera."""
    return f"{camera(name)}/rgb"


def camera_depth(name: str) -> str:
    """Return the entity of the depth images of a camera."""
    return f"{camera(name)}/depth"


def camera_classes(name: str) -> str:
    """Return the entity of the images of classes of a camera."""
    return f"{camera(name)}/classes"


def camera_instances(name: str) -> str:
    """Return the entity of the images of objects of a camera."""
    return f"{camera(name)}/instances"
