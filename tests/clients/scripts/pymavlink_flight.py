"""Plain pymavlink over TCP: parameters, a mission by hand, takeoff, landing."""

import sys
import time

from pymavlink import mavutil


def command(link, number, *params):
    """Send a COMMAND_LONG and return the result that it is acknowledged with."""
    params = (*params, *(0.0,) * (7 - len(params)))
    link.mav.command_long_send(link.target_system, link.target_component, number, 0, *params)
    while True:
        ack = link.recv_match(type="COMMAND_ACK", blocking=True, timeout=5)
        assert ack is not None, f"command {number} was not acknowledged"
        if ack.command == number:
            return ack.result


def wait(link, message_type, is_reached, timeout_s=30.0):
    deadline = time.monotonic() + timeout_s
    while time.monotonic() < deadline:
        message = link.recv_match(type=message_type, blocking=True, timeout=2)
        if message is not None and is_reached(message):
            return message
    raise AssertionError(f"{message_type} did not come to what was waited for")


def read_parameters(link):
    link.param_fetch_all()
    names, count = set(), None
    while count is None or len(names) < count:
        value = link.recv_match(type="PARAM_VALUE", blocking=True, timeout=5)
        assert value is not None, f"{len(names)} of {count} parameters"
        if value.param_index != 65535:
            names.add(value.param_id)
            count = value.param_count
    return names


def upload_mission(link, latitude, longitude):
    items = [(22, 8.0), (16, 12.0), (21, 0.0)]
    link.mav.mission_count_send(link.target_system, link.target_component, len(items), 0)
    while True:
        message = link.recv_match(
            type=["MISSION_REQUEST_INT", "MISSION_REQUEST", "MISSION_ACK"], blocking=True, timeout=5
        )
        assert message is not None
        if message.get_type() == "MISSION_ACK":
            return message.type
        number, altitude = items[message.seq]
        link.mav.mission_item_int_send(
            *(link.target_system, link.target_component, message.seq, 6, number, 0, 1),
            *(0.0, 0.0, 0.0, float("nan"), latitude, longitude, altitude, 0),
        )


def run(address):
    link = mavutil.mavlink_connection(address, source_system=255)
    heartbeat = link.wait_heartbeat(timeout=20)
    assert heartbeat is not None
    assert heartbeat.autopilot == mavutil.mavlink.MAV_AUTOPILOT_PX4
    assert "MIS_TAKEOFF_ALT" in read_parameters(link)

    wait(link, "SYS_STATUS", lambda m: m.onboard_control_sensors_health & 1 << 28)
    assert command(link, 4242) == mavutil.mavlink.MAV_RESULT_UNSUPPORTED
    assert command(link, 400, float("nan"), 0.0) == mavutil.mavlink.MAV_RESULT_DENIED
    assert command(link, 511, 33, 50_000) == 0
    home = wait(link, "HOME_POSITION", lambda _: True)
    assert upload_mission(link, home.latitude, home.longitude) == 0

    link.mav.command_long_send(1, 7, 400, 0, 1, 0, 0, 0, 0, 0, 0)  # to another component
    link.arducopter_arm()
    wait(link, "HEARTBEAT", lambda m: m.base_mode & mavutil.mavlink.MAV_MODE_FLAG_SAFETY_ARMED)
    link.set_mode("MISSION")
    reached = [wait(link, "MISSION_ITEM_REACHED", lambda _: True).seq for _ in range(2)]
    assert reached == [0, 1], reached
    assert link.flightmode == "MISSION"
    top = wait(link, "GLOBAL_POSITION_INT", lambda m: m.relative_alt > 11_000)
    assert abs(top.lat - home.latitude) < 100
    wait(link, "HEARTBEAT", lambda m: not m.base_mode & 128, timeout_s=40.0)
    link.close()


run(sys.argv[1])
