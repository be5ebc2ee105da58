"""Pilots for goals in words: simple rules, and a model behind a real server on loopback."""

import base64
import json
import socket
import threading
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from aeroscene.sources import load_scene
from flightsim.testbench import TestbenchCfg, TestbenchError
from flightsim.vehicles import airframe_by_name
from scenarios.baselines.area_choosers import (
    PERFECT,
    at_random,
    first_kind,
    nearest_of_kind,
    of_the_one,
)
from scenarios.baselines.named import PilotError, pilot_of
from scenarios.baselines.vlm_answers import AnswerError, Choice, read_choice
from scenarios.chat.completions import ChatError, ChatModel
from scenarios.mission.goals import fitting_areas
from scenarios.run.cfg import SitlCfg
from scenarios.run.companion import Insight
from scenarios.run.sitl import Sitl
from scenarios.trials.verdict import Code, Fate
from scenarios.words.goal_choice import choose_goal

HUMMINGBIRD = airframe_by_name("hummingbird")


@contextmanager
def model(answers):
    """A server that answers as the API does; yields its address and the questions."""
    asked = []

    class Handler(BaseHTTPRequestHandler):
        def do_POST(self):
            length = int(self.headers["Content-Length"])
            asked.append(json.loads(self.rfile.read(length))["messages"])
            content = answers(asked)
            message = {"role": "assistant", "content": content}
            body = json.dumps({"choices": [{"message": message}]}).encode()
            self.send_response(200)
            self.send_header("Content-Length", str(len(body)))
            self.end_headers()
            self.wfile.write(body)

        def log_message(self, format, *args):  # noqa: A002 - the name is the base's
            pass

    with ThreadingHTTPServer(("127.0.0.1", 0), Handler) as server:
        thread = threading.Thread(target=server.serve_forever, args=(0.01,), daemon=True)
        thread.start()
        try:
            yield f"http://127.0.0.1:{server.server_address[1]}/v1", asked
        finally:
            server.shutdown()
            thread.join()


def images_of(messages):
    """Colours of the images of a question."""
    for part in messages[1]["content"]:
        if part["type"] == "image_url":
            head, data = part["image_url"]["url"].split(",")
            assert head == "data:image/jpeg;base64"
            yield cv2.imdecode(np.frombuffer(base64.b64decode(data), np.uint8), cv2.IMREAD_COLOR)


def to_the_reddest(asked):
    """Points at what is red in the views ahead: goes there while it is small, then lands on it."""
    found = []
    for number, image in enumerate(list(images_of(asked[-1]))[:-1]):
        blue, green, red = image.astype(float).transpose(2, 0, 1)
        rows, columns = np.nonzero((red > 90) & (red > 2.0 * green) & (red > 2.0 * blue))
        place = (columns.mean() / image.shape[1], rows.mean() / image.shape[0]) if len(rows) else 0
        found.append((len(rows), number, place))
    size, number, place = max(found, key=lambda each: each[0])
    assert size > 0
    action = "land" if len(asked) > 1 else "go"
    answer = {"action": action, "image": number, "x": place[0], "y": place[1]}
    return f"I see it.\n```json\n{json.dumps(answer)}\n```"


def fly(address, **more):
    pilot = pilot_of("vlm", chat=ChatModel(endpoint=address, **more))
    cfg = SitlCfg(scene="field", goal="words", bench=TestbenchCfg(speed="max"))
    with Sitl(pilot.brief(cfg), pilot=pilot.make, has_network=False) as sitl:
        return sitl.run(), sitl


def test_a_model_that_sees_lands_where_the_text_says():
    with model(to_the_reddest) as (address, asked):
        result, sitl = fly(address)
    assert result.code == Code.LANDED, result.reason
    assert len(asked) == 2
    assert asked[0][1]["content"][0]["text"] == sitl.words.text == result.text
    assert [len(list(images_of(messages))) for messages in asked] == [7, 7]
    assert result.navigation_error_m < 0.3


def test_an_answer_that_is_not_understood_ends_the_flight_safely():
    with model(lambda _: "I would rather look at the sky.") as (address, asked):
        result, _ = fly(address)
    assert (result.code, result.fate) == (Code.GAVE_UP, Fate.SAFE_DOWN), result.reason
    assert "the model's answer is not understood: " in result.reason
    assert "I would rather look at the sky." in result.reason
    assert len(asked) == 2
    assert "That was not understood" in asked[1][-1]["content"]


def test_an_endpoint_that_is_not_there_is_named():
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
    with pytest.raises(ChatError, match=f"endpoint 'http://127.0.0.1:{port}' cannot be used"):
        fly(f"http://127.0.0.1:{port}")


@pytest.mark.parametrize(
    ("content", "says"),
    [
        ("", "holds no JSON object"),
        ("the red roof", "holds no JSON object"),
        ('{"action": "dive"}', "is no choice"),
        ('{"action": "land", "x": 1.5}', "is no choice"),
        ('{"action": "land", "x": NaN}', "is no choice"),
        ('{"action": "land", "image": 7}', "image 7 is not there; valid: 0 to 6"),
        ('{"action": "go", "run": "rm"}', "unknown field `run`"),
        ("{" * 100_000 + "}", "is no choice"),
        ('{"action": "dive\x1b[2J"}', "is no choice"),
    ],
)
def test_an_answer_that_is_no_choice_is_refused_in_one_line(content, says):
    with pytest.raises(AnswerError, match=says) as refusal:
        read_choice(content, 7)
    assert str(refusal.value).isprintable()
    assert len(str(refusal.value)) < 400


def test_words_around_an_answer_are_left_out():
    content = 'Sure!\n```json\n{"action": "land", "image": 6, "x": 0, "y": 1}\n```\nGood luck.'
    assert read_choice(content, 7) == Choice(action="land", image=6, x=0.0, y=1.0)


def test_a_model_needs_an_address_and_an_address_a_model():
    with pytest.raises(PilotError, match="pilot is 'vlm' with no endpoint; valid: --pilot vlm"):
        pilot_of("vlm")
    with pytest.raises(PilotError, match="pilot is 'demo' with endpoint 'http://a'"):
        pilot_of("demo", chat=ChatModel(endpoint="http://a"))
    with pytest.raises(PilotError, match="endpoint is 'ftp://a'; valid: an address such as"):
        pilot_of("vlm", chat=ChatModel(endpoint="ftp://a"))


@pytest.fixture(scope="module")
def told():
    """A pilot's equipment and insight in a shipped scene."""
    scene = load_scene("45")
    goal = choose_goal(scene, HUMMINGBIRD, asked="relation", seed=5)
    aboard = SimpleNamespace(text=goal.text, airframe=HUMMINGBIRD, scene=scene)
    return aboard, Insight(scene=scene, description=goal.description), goal


def test_perfect_perception_finds_the_areas_of_the_text(told):
    aboard, insight, goal = told
    assert {area.id for area in of_the_one(aboard, insight)} == {area.id for area in goal.areas}


def test_chance_takes_any_area_and_the_same_one_for_the_same_text(told):
    aboard, insight, _ = told
    areas = at_random(aboard, insight)
    assert areas == at_random(aboard, insight)
    every = fitting_areas(insight.scene, HUMMINGBIRD)
    assert sorted(area.id for area in areas) == sorted(area.id for area in every)
    others = {
        at_random(SimpleNamespace(**{**vars(aboard), "text": str(i)}), insight)[0].id
        for i in range(9)
    }
    assert len(others) > 3


def test_the_nearest_of_the_kind_reads_the_first_noun(told):
    aboard, insight, goal = told
    areas = nearest_of_kind(aboard, insight)
    kinds = {insight.scene.object_by_id[area.object_id].category for area in areas}
    assert kinds == {goal.description.kind}


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ("Land on the coffee table next to the table.", "coffee_table"),
        ("Find the room with the carpet and two cars in it. Land there.", "room"),
        ("Land on the tower block east of the building.", "tower"),
        ("Go away.", None),
    ],
)
def test_a_text_names_its_own_kind_first(text, kind):
    assert first_kind(text) == kind


def test_a_rule_for_texts_refuses_a_goal_that_is_an_area():
    with pytest.raises(TestbenchError, match="the goal is an area; valid: goals naming"):
        PERFECT(SimpleNamespace(insight=None))
