"""Programs that fly over MAVLink, and what they do wrong."""

import json
import shlex
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
from pymavlink.dialects.v20 import common

from scenarios.campaigns.external.program import Program, ProgramError
from scenarios.campaigns.flyer import Flyer, Suite, Trial
from scenarios.tasks.recipe import Recipe
from tests.instances import own_instance

EXAMPLE = Path(__file__).parents[3] / "examples" / "scored_mavlink.py"
TRIAL = Trial("field", "iris", 0)
CONNECT = """
import json, sys, time
from pymavlink import mavutil
drone = mavutil.mavlink_connection(json.loads(sys.stdin.readline())["url"])
"""
FLOOD = """
import json, socket, sys
host, port = json.loads(sys.stdin.readline())["url"].split(":")[1:]
drone = socket.create_connection((host, int(port)))
while True:
    drone.sendall({!r} * 100)
"""


def python(source):
    return shlex.join([sys.executable, "-c", source])


def row_of(source, patience_s=100.0):
    suite = Suite(pilot="mavlink", program=python(source))
    with Flyer(suite, patience_s=patience_s) as flyer:
        return flyer.fly(TRIAL)


@pytest.mark.parametrize(
    ("source", "code", "reason"),
    [
        ("raise SystemExit('first\\n\\nno  map')", "raised", "no map"),
        (
            CONNECT + "drone.mav.command_long_send(0, 0, 31010, 0, 50, *[0.0] * 6)\n"
            "drone.recv_match(type='COMMAND_ACK', blocking=True)\n1 / 0",
            "raised",
            "ZeroDivisionError: division by zero",
        ),
        ("raise SystemExit(3)", "raised", "the program ended with status 3"),
        ("", "never_flew", "never left the ground"),
    ],
)
def test_a_program_that_ends_by_itself_is_told_by_its_last_words(source, code, reason):
    row = row_of(source)
    assert (row["success"], row["code"], row["reason"]) == (False, code, reason)


@pytest.mark.parametrize(
    ("source", "reason"),
    [
        ("import time; time.sleep(600)", "no heartbeat within 3 s"),
        ("import sys\nwhile True: sys.stderr.write('x' * 9999)", "no heartbeat within 3 s"),
    ],
)
def test_a_program_that_is_silent_is_ended(source, reason):
    row = row_of(source, patience_s=3.0)
    assert (row["success"], row["code"], row["reason"]) == (False, "hung", reason)


def test_a_program_that_floods_without_granting_time_is_ended():
    ping = common.MAVLink(None).ping_encode(0, 0, 0, 0).pack(common.MAVLink(None))
    row = row_of(FLOOD.format(ping), patience_s=5.0)
    assert (row["success"], row["code"]) == (False, "hung")
    assert row["reason"] == "no end in 5 s: it grants no time, see docs/lockstep.md"


def test_what_a_program_has_started_ends_with_it():
    marker = "sleep 617.25"
    program = Program(f"sh -c '{marker} & exec {marker}'", "{}", is_shown=False)
    program.end(0.0)
    deadline_s = time.monotonic() + 10.0
    while marker in subprocess.run(["ps", "ax"], capture_output=True, text=True, check=True).stdout:
        assert time.monotonic() < deadline_s
        time.sleep(0.05)


@pytest.mark.parametrize("command", ["", "no-such-stack --fast", "python 'my stack"])
def test_a_program_that_is_not_there_is_one_line(command):
    suite = Suite(pilot="mavlink", program=command)
    with pytest.raises(ProgramError, match=r"^program .*; valid: a command such as") as caught:
        suite.require_pilot()
    assert "\n" not in str(caught.value)


def test_the_touchdown_error_counts_from_the_point_that_the_program_has_chosen():
    chosen = (
        "drone.mav.landing_target_send(0, 0, mav.MAV_FRAME_LOCAL_NED, 0, 0, 0, 0, 0, "
        "x=north + 0.4, y=east, z=-up, position_valid=1)"
    )
    # The position is an extension of MAVLink 2.
    source = f"import os\nos.environ['MAVLINK20'] = '1'\n{EXAMPLE.read_text()}"
    mark = "    step(drone, 150)"
    assert mark in source
    calm = Recipe(wind_mps=(0.0, 0.0))
    rows = []
    for text in (source, source.replace(mark, f"    {chosen}\n{mark}")):
        suite = Suite(recipe=calm, pilot="mavlink", program=python(text))
        with Flyer(suite, patience_s=100.0) as flyer:
            rows.append(flyer.fly(TRIAL))
    centred, aside = rows
    assert centred["state_hash"] == aside["state_hash"]
    assert centred["touchdown_error_m"] < 0.2
    assert aside["touchdown_error_m"] == pytest.approx(0.4, abs=0.2)
    assert aside["touchdown_error_m"] != centred["touchdown_error_m"]


def test_a_client_that_comes_by_itself_finds_its_task_on_standard_output(capsys):
    suite = Suite(recipe=Recipe(wind_mps=(0.0, 0.0)), pilot="mavlink")
    port = 5760 + 10 * own_instance()
    rows = []
    with Flyer(suite, patience_s=100.0, port=port) as flyer:
        flight = threading.Thread(target=lambda: rows.append(flyer.fly(TRIAL)), daemon=True)
        flight.start()
        line, deadline_s = "", time.monotonic() + 60.0
        while not line.endswith("\n"):
            assert time.monotonic() < deadline_s
            line += capsys.readouterr().out
            time.sleep(0.05)
        assert json.loads(line)["url"] == f"tcp:127.0.0.1:{port}"
        subprocess.run([sys.executable, str(EXAMPLE)], input=line, text=True, check=True)
        flight.join(60.0)
    assert [row["code"] for row in rows] == ["landed"], rows


HEAR = """
import json, os, sys
os.environ["MAVLINK20"] = "1"
from pymavlink import mavutil
task = json.loads(sys.stdin.readline())
drone = mavutil.mavlink_connection(task["url"])
parts = []
while not parts or len(parts[-1].text) == 50:
    drone.mav.command_long_send(0, 0, 31010, 0, 300, *[0.0] * 6)
    message = drone.recv_match(type="STATUSTEXT", blocking=True)
    if parts or message.text.startswith("Goal: "):
        parts.append(message)
heard = "".join(part.text for part in sorted(parts, key=lambda part: part.chunk_seq))
raise SystemExit(json.dumps([task["area"], task["scene_file"], heard == "Goal: " + task["goal"]]))
"""


def test_a_program_reads_and_hears_a_goal_in_words_and_learns_no_area():
    recipe = Recipe(goals=("naming",), map=("onboard",), draws=1)
    suite = Suite(pilot="mavlink", program=python(HEAR), recipe=recipe)
    with Flyer(suite, patience_s=100.0) as flyer:
        row = flyer.fly(Trial("45", "hummingbird", 0))
    assert row["text"]
    assert (row["code"], row["reason"]) == ("raised", "[null, null, true]")
