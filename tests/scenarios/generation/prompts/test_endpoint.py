"""A language model's answer is data from a stranger: a real server on loopback gives any."""

import json
import socket
import threading
import time
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import pytest

from scenarios.generation.prompts.endpoint import ask_endpoint
from scenarios.generation.prompts.wishes import PromptError

PROMPT = "a harbour with two cafes"
WISHES = {
    "theme": "waterfront",
    "density": 1.5,
    "outline_m": [80, 60],
    "counts": [{"thing": "cafe", "least": 2, "most": 2, "said": "two cafes"}],
    "relations": [{"thing": "bench", "relation": "along", "host": "water", "least": 3}],
    "readings": [{"option": "theme", "said": "harbour"}],
    "not_understood": ["crane"],
}


def answer(content):
    """The body of a server that speaks as OpenAI's does."""
    text = content if isinstance(content, str) else json.dumps(content)
    return json.dumps({"choices": [{"message": {"role": "assistant", "content": text}}]}).encode()


@contextmanager
def serving(body=b"", status=200, headers=(), drip_s=0.0):
    """A server on loopback; yields its address and what it was sent."""
    seen = []

    class Handler(BaseHTTPRequestHandler):
        def do_POST(self):
            length = int(self.headers["Content-Length"])
            seen.append((self.path, dict(self.headers), json.loads(self.rfile.read(length))))
            self.send_response(status)
            for name, value in headers:
                self.send_header(name, value)
            self.send_header("Content-Length", str(len(body)))
            self.end_headers()
            if not drip_s:
                self.wfile.write(body)
                return
            try:
                for byte in body:
                    self.wfile.write(bytes([byte]))
                    self.wfile.flush()
                    time.sleep(drip_s)
            except OSError:
                seen.append("cut off")

        def log_message(self, format, *args):  # noqa: A002 - the name is the base's
            pass

    with ThreadingHTTPServer(("127.0.0.1", 0), Handler) as server:
        server.daemon_threads = False  # the end of the block waits for them
        thread = threading.Thread(target=server.serve_forever, args=(0.01,), daemon=True)
        thread.start()
        try:
            yield f"http://127.0.0.1:{server.server_address[1]}/v1", seen
        finally:
            server.shutdown()
            thread.join()


def asked(body, **more):
    with serving(body, **more) as (address, _):
        return ask_endpoint(PROMPT, address, "small", {})


def refused(body, **more):
    with pytest.raises(PromptError) as refusal:
        asked(body, **more)
    line = str(refusal.value)
    assert "\n" not in line
    assert "; valid: " in line
    return line


def test_an_answer_becomes_the_wishes_that_our_parser_makes():
    with serving(answer(WISHES)) as (address, seen):
        wishes = ask_endpoint(PROMPT, address, "small", {})
    assert (wishes.theme, wishes.density, wishes.outline_m) == ("waterfront", 1.5, (80, 60))
    assert [(e.title, e.number) for e in wishes.demands] == [
        ("cafe", "2"),
        ("bench along water", "at least 3"),
    ]
    assert wishes.not_understood == ("crane",)
    ((path, headers, sent),) = seen
    assert path == "/v1/chat/completions"
    assert sent["model"] == "small"
    assert sent["messages"][1] == {"role": "user", "content": PROMPT}
    assert "bicycle_stand" in sent["messages"][0]["content"]
    schema = sent["response_format"]["json_schema"]["schema"]
    assert set(WISHES) <= set(schema["$defs"]["Wishes"]["properties"])
    assert "Authorization" not in headers


@pytest.mark.parametrize("path", ["", "/", "/chat/completions"])
def test_the_address_may_end_as_users_write_it(path):
    with serving(answer(f"```json\n{json.dumps(WISHES)}\n```")) as (address, seen):
        assert ask_endpoint(PROMPT, address + path, "small", {}).theme == "waterfront"
    assert seen[0][0] == "/v1/chat/completions"


def test_a_key_is_sent_where_there_is_one_and_never_shown():
    with serving(answer(WISHES)) as (address, seen):
        ask_endpoint(PROMPT, address, "small", {"OPENAI_API_KEY": " secret \n"})
        with pytest.raises(PromptError) as refusal:
            ask_endpoint(PROMPT, address, "small", {"OPENAI_API_KEY": "sec\r\nX-More: ret"})
    assert [headers["Authorization"] for _, headers, _ in seen] == ["Bearer secret"]
    assert "sec" not in str(refusal.value).replace("characters", "")


def test_a_checkpoint_may_have_themes_of_its_own():
    with serving(answer({"theme": "space_port"})) as (address, seen):
        own = frozenset(("space_port",))
        wishes = ask_endpoint(PROMPT, address, "small", {}, own_themes=own)
    assert wishes.theme == "space_port"
    assert ", space_port" in seen[0][2]["messages"][0]["content"]


def test_names_that_are_not_in_the_vocabulary_are_not_understood():
    wishes = asked(
        answer(
            {
                "theme": "__import__('os').system('true')",
                "counts": [
                    {"thing": "crane", "said": "a crane"},
                    {"thing": "../../etc/passwd"},
                    {"thing": "car", "least": 2},
                ],
                "relations": [
                    {"thing": "car", "relation": "behind", "host": "tree", "said": "cars behind"},
                    {"thing": "car", "relation": "between", "host": "house", "other": "moon"},
                ],
            }
        )
    )
    assert wishes.theme is None
    assert [each.title for each in wishes.demands] == ["car"]
    words = " | ".join(wishes.not_understood)
    assert "a crane (no thing 'crane'" in words
    assert "../../etc/passwd (no thing" in words
    assert "cars behind (a tree has no front)" in words
    assert "no thing 'moon'" in words
    assert "theme __import__" in words


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("I cannot help with that.", "gave no wishes (JSON is malformed"),
        ("", "gave no wishes (Input data was truncated"),
        ("[]", "gave no wishes (Expected `object`, got `array`"),
        ('{"shell": "rm -rf"}', "unknown field `shell`"),
        ('{"counts": [{"thing": 7}]}', "Expected `str`, got `int`"),
        ('{"counts": [{"thing": "car", "least": -1}]}', "Expected `int` >= 0"),
        ('{"counts": [{"thing": "car", "least": 1e400}]}', "gave no wishes"),
        ('{"counts": [{"thing": "car", "least": ' + "9" * 5000 + "}]}", "gave no wishes"),
        ('{"counts": [' + '{"thing": "car"},' * 40 + '{"thing": "car"}]}', "length <= 24"),
        ('{"theme": "' + "x" * 5000 + '"}', "length <= 60"),
        ('{"density": NaN}', "gave no wishes"),
        ('{"relations": [{"thing": "car", "relation": "eats", "host": "car"}]}', "'eats'"),
        ("[" * 100_000, "gave no wishes"),
        ('{"density": 900}', "density 900.0 is out of range; valid: 0.2 to 2"),
        ('{"counts": [{"thing": "car", "least": 999}]}', "number of car 999 is out of range"),
        ('{"outline_m": [9000, 60]}', "outline 9000.0 is out of range; valid: 15 to 150 m"),
        (
            '{"counts": [{"thing": "car", "least": 3}, {"thing": "car", "least": 0, "most": 0}]}',
            "asks for at least 3 and for 0 of car",
        ),
    ],
)
def test_an_answer_that_is_no_wish_is_refused_in_one_line(content, message):
    assert message in refused(answer(content))


@pytest.mark.parametrize(
    ("body", "message"),
    [
        (b"", "gave no message"),
        (b"<html>", "gave no message"),
        (b'{"choices": []}', "length >= 1"),
        (b'{"choices": [{"message": {"content": null}}]}', "Expected `str`, got `null`"),
        (b"\xff\xfe", "gave no message"),
        (b" " * 300_000, "answered with more than 262144 bytes"),
    ],
)
def test_a_body_that_is_no_answer_is_refused_in_one_line(body, message):
    assert message in refused(body)


def test_a_status_is_named_with_what_the_server_said():
    line = refused(b'{"error": "no such\nmodel"}', status=404)
    assert 'answered with status 404 ({"error": "no such model"})' in line


def test_no_redirect_is_followed():
    with serving(answer(WISHES)) as (other, seen):
        line = refused(b"", status=302, headers=[("Location", f"{other}/chat/completions")])
    assert "status 302" in line
    assert seen == []


def test_a_server_that_drips_is_cut_off_when_its_time_is_over():
    with (
        serving(answer(WISHES), drip_s=0.05) as (address, seen),
        pytest.raises(PromptError) as refusal,
    ):
        ask_endpoint(PROMPT, address, "small", {}, most_seconds=0.4)
    assert "did not answer within 0.4 s" in str(refusal.value)
    assert seen[-1] == "cut off"


def test_a_server_that_says_nothing_is_given_up():
    with socket.create_server(("127.0.0.1", 0)) as silent:
        address = f"http://127.0.0.1:{silent.getsockname()[1]}/v1"
        with pytest.raises(PromptError) as refusal:
            ask_endpoint(PROMPT, address, "small", {}, most_seconds=0.3)
    assert "did not answer within 0.3 s" in str(refusal.value)


def test_a_server_that_is_not_there_is_named():
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
    with pytest.raises(PromptError) as refusal:
        ask_endpoint(PROMPT, f"http://127.0.0.1:{port}", "small", {})
    assert "cannot be used (ConnectionRefusedError" in str(refusal.value)


@pytest.mark.parametrize(
    "endpoint",
    [
        "127.0.0.1:8080",
        "ftp://127.0.0.1/v1",
        "file:///etc/passwd",
        "http://",
        "http://a b/v1",
        "http://127.0.0.1:99999/v1",
        "http://127.0.0.1:port/v1",
        "http://user:secret@127.0.0.1/v1",
        "http://127.0.0.1/v1\r\nX: y",
        "http://[::1/v1",
    ],
)
def test_an_address_that_is_none_is_refused(endpoint):
    with pytest.raises(
        PromptError, match=r"prompt-endpoint is .*valid: an address such as http://127"
    ):
        ask_endpoint(PROMPT, endpoint, "small", {})
