"""Messages that change nothing: the sender gets one text for each kind of message.

A client that sends such a message expects something of it. Silence would leave its user to guess.
"""

from __future__ import annotations

from collections.abc import Mapping

from flightsim.autopilot.events import Severity
from flightsim.mavlink.channel import Channel
from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.parsing import Message
from flightsim.mavlink.statustext import StatustextSender

_HARDWARE_IN_THE_LOOP = "the vehicle is simulated already"
_OWN_SENSOR = "the vehicle measures that itself"
_MISSION_PROTOCOL = "MISSION_COUNT with the mission type begins a transfer"
_REASONS: Mapping[str, str] = {
    "ACTUATOR_CONTROL_TARGET": "valid are setpoints, and MAV_CMD_ACTUATOR_TEST on the ground",
    "ADSB_VEHICLE": "the vehicle does not avoid other aircraft",
    "CHANGE_OPERATOR_CONTROL": "every client may command",
    "DISTANCE_SENSOR": _OWN_SENSOR,
    "FENCE_FETCH_POINT": _MISSION_PROTOCOL,
    "FENCE_POINT": _MISSION_PROTOCOL,
    "GPS_INJECT_DATA": "the receiver has its corrections by --gnss rtk",
    "GPS_RTCM_DATA": "the receiver has its corrections by --gnss rtk",
    "HIL_ACTUATOR_CONTROLS": _HARDWARE_IN_THE_LOOP,
    "HIL_CONTROLS": _HARDWARE_IN_THE_LOOP,
    "HIL_GPS": "valid is GPS_INPUT",
    "HIL_OPTICAL_FLOW": _HARDWARE_IN_THE_LOOP,
    "HIL_RC_INPUTS_RAW": "valid are RC_CHANNELS_OVERRIDE and MANUAL_CONTROL",
    "HIL_SENSOR": _HARDWARE_IN_THE_LOOP,
    "HIL_STATE": _HARDWARE_IN_THE_LOOP,
    "HIL_STATE_QUATERNION": _HARDWARE_IN_THE_LOOP,
    "LED_CONTROL": "there are no lights",
    "MANUAL_SETPOINT": "valid are MANUAL_CONTROL and SET_ATTITUDE_TARGET",
    "OPTICAL_FLOW": _OWN_SENSOR,
    "OPTICAL_FLOW_RAD": _OWN_SENSOR,
    "PLAY_TUNE": "there is no buzzer",
    "PLAY_TUNE_V2": "there is no buzzer",
    "RALLY_FETCH_POINT": _MISSION_PROTOCOL,
    "RALLY_POINT": _MISSION_PROTOCOL,
    "SETUP_SIGNING": "this link does not sign",
    "SET_ACTUATOR_CONTROL_TARGET": "valid are setpoints, and MAV_CMD_ACTUATOR_TEST on the ground",
    "SET_HOME_POSITION": "valid is MAV_CMD_DO_SET_HOME",
    "TERRAIN_DATA": "the scene's relief serves as the terrain, or else the height of home",
    "TRAJECTORY_REPRESENTATION_BEZIER": "valid are setpoints",
    "TRAJECTORY_REPRESENTATION_WAYPOINTS": "valid are setpoints",
    "VISION_POSITION_DELTA": "valid are ODOMETRY and VISION_POSITION_ESTIMATE",
    "WHEEL_DISTANCE": "there are no wheels",
}
"""Reason why a message changes nothing. Most of these name no addressee, but are meant for a
vehicle."""
_ANSWERS = frozenset(
    {
        *("COMMAND_ACK", "LOGGING_ACK", "LOGGING_DATA", "LOGGING_DATA_ACKED", "MOUNT_STATUS"),
        *("PARAM_ERROR", "RESPONSE_EVENT_ERROR", "GIMBAL_DEVICE_ATTITUDE_STATUS"),
        "AUTOPILOT_STATE_FOR_GIMBAL_DEVICE",
        # MAVProxy asks every component, and no group has a message of camera or gimbal.
        "REQUEST_DATA_STREAM",
    }
)
"""Messages with an addressee that need no answer, or none that a component has."""
_USUAL = "this vehicle does not use it"


class IgnoredMessages:
    """Notices to clients whose messages are ignored.

    Each client gets one for each kind of message, so its memory is bounded by the number of kinds.
    """

    def __init__(self, statustext: StatustextSender) -> None:
        self._statustext = statustext
        self._explained: dict[Channel, set[int]] = {}

    def explain(self, channel: Channel, message: Message, reason: str) -> None:
        """Send a client the reason why its message changes nothing, once for each kind of message.

        Args:
            channel: The client.
            message: Its message.
            reason: The reason.
        """
        explained = self._explained.setdefault(channel, set())
        if message.get_msgId() not in explained:
            explained.add(message.get_msgId())
            text = f"{message.get_type()} is ignored: {reason}"
            self._statustext.answer(channel, Severity.WARNING, text)

    def forget(self, channel: Channel) -> None:
        """Drop a partner that left."""
        self._explained.pop(channel, None)


def reason_for(message: Message) -> str:
    """Return why a message that no service handles changes nothing; empty if it is not for us.

    Telemetry of other vehicles, and answers, are for nobody in particular.
    """
    name = message.get_type()
    has_addressee = hasattr(message, "target_system") and name not in _ANSWERS
    if has_addressee:
        return _REASONS.get(name, _USUAL)
    is_telemetry = message.get_srcComponent() == mav.MAV_COMP_ID_AUTOPILOT1
    return "" if is_telemetry else _REASONS.get(name, "")
