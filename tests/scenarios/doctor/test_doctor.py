import json
import socket

from scenarios.doctor import network
from scenarios.doctor.check import Check
from scenarios.doctor.diagnosis import diagnose
from tests.scenarios.in_process import in_process


def test_json_is_one_object_and_this_machine_can_fly(capsys):
    status, out, _ = in_process(capsys, "doctor", "--json")
    diagnosis = json.loads(out)
    checks = {check["name"]: check for check in diagnosis["checks"]}
    problems = [check for check in diagnosis["checks"] if check["status"] == "problem"]
    assert status == 0, problems
    assert diagnosis["can_fly"] is True
    assert {"python", "mujoco-core", "take-off", "renderer", "viewer", "TCP 5760"} <= checks.keys()
    assert checks["take-off"]["value"].startswith("climbed ")
    assert checks["renderer"]["value"].split()[0] in {"gl", "raycast"}


def test_every_check_that_is_not_ok_says_what_to_do():
    with socket.socket() as taken:
        taken.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            taken.bind(("127.0.0.1", 5760))
            taken.listen()
        except OSError:
            pass  # in use already, which is what the check should see
        (tcp,) = [check for check in network.check_ports() if check.name == "TCP 5760"]
    assert tcp.status == "note"
    assert tcp.value == "in use"
    assert "--instance" in tcp.remedy


def test_a_check_that_breaks_is_a_problem_and_the_others_go_on():
    def half():
        yield Check(name="first", status="ok", value="fine")
        raise RuntimeError("the\nengine is gone")

    def other():
        yield Check(name="last", status="note", value="so so", remedy="try")

    shares = []
    diagnosis = diagnose(lambda _, share: shares.append(share), {"half": half, "other": other})
    assert [check.name for check in diagnosis.checks] == ["first", "half", "last"]
    broken = diagnosis.checks[1]
    assert broken.status == "problem"
    assert broken.value == "RuntimeError: the engine is gone"
    assert broken.remedy
    assert not diagnosis.can_fly
    assert shares == [0.0, 0.5, 1.0]
