"""`aeroscene generate --prompt` as a user meets it."""

import json

import pytest

from aeroscene.scene.io import read_scene
from tests.scenarios.generation.prompts.test_endpoint import answer, serving
from tests.scenarios.in_process import in_process

pytestmark = pytest.mark.usefixtures("one_torch_thread")


def run(capsys, *args):
    return in_process(capsys, "generate", *args)


@pytest.mark.parametrize(
    ("args", "message"),
    [
        (
            ("--prompt", "no cars and two cars"),
            "asks for 0 and for 2 of car; valid: one of the two",
        ),
        (("--prompt", "a park of 300 by 20 m"), "prompt: outline 300.0 is out of range; valid: 15"),
        (("--prompt", "qwertz"), "prompt 'qwertz' has no wish that is understood; valid: English"),
        (("--prompt-endpoint", "http://127.0.0.1:1"), "without --prompt; valid: the two together"),
        (("--prompt-model", "small"), "without --prompt-endpoint; valid: the two together"),
        (
            ("--prompt", "a park", "--prompt-endpoint", "localhost"),
            "prompt-endpoint is 'localhost'; valid: an address such as http://127.0.0.1:8080/v1",
        ),
        (("--prompt", "a park", "--complete", "42"), "theme is 'park' beside a scene to complete"),
    ],
)
def test_what_cannot_be_asked_for_is_refused_before_anything_is_loaded(
    tmp_path, capsys, monkeypatch, args, message
):
    from aeroscene.learning.generation import Generator

    monkeypatch.setattr(Generator, "load", lambda *_, **__: pytest.fail("the model was loaded"))
    out = tmp_path / "out"
    status, text, errors = run(capsys, "--out", out, *args)
    assert (status, text) == (2, "")
    assert message in errors
    assert errors.count("\n") == 1
    assert not out.exists()


def test_a_prompt_is_told_met_and_named_in_the_document(tmp_path, capsys):
    prompt = "25 objects in a small office with a crane, a desk and no boats"
    status, text, errors = run(capsys, "--prompt", prompt, "--seed", 3, "--out", tmp_path)
    assert (status, errors) == (0, "")
    words = " ".join(text.split())
    assert words.startswith(
        "understood in office theme: office 25 objects objects: 25 small outline:"
    )
    assert "desk desk: at least 1 no boats boat: 0 not understood: crane" in words
    assert words.index("not understood") < words.index("asked for")
    scene = read_scene(tmp_path / "aeroscene-0003.json")
    assert scene.theme == "office"
    assert scene.wishes["prompt"] == prompt
    assert (scene.wishes["desk"], scene.wishes["boat"]) == ("at least 1", "0")
    desks = sum(obj.category == "desk" for obj in scene.objects)
    assert (scene.measured["desk"], scene.measured["boat"]) == (desks, 0)


def test_an_endpoint_reads_the_prompt_and_options_win(tmp_path, capsys):
    body = answer({"theme": "old_town", "counts": [{"thing": "crane"}, {"thing": "tree"}]})
    with serving(body) as (address, seen):
        args = ("--prompt", "trees", "--prompt-endpoint", address, "--prompt-model", "small")
        status, text, errors = run(
            capsys, *args, "--theme", "park", "--objects", 30, "--out", tmp_path, "--json"
        )
    assert (status, errors) == (0, "")
    assert seen[0][2]["model"] == "small"
    facts = json.loads(text)
    assert facts["understood"]["prompt"] == "trees"
    assert facts["understood"]["notes"][0] == "--theme park wins over the prompt's theme old_town"
    assert "crane" in facts["understood"]["not_understood"][0]
    (file,) = facts["scenes"]
    scene = read_scene(file)
    trees = sum(obj.category == "tree" for obj in scene.objects)
    assert facts["wishes"][file]["tree"] == {"asked": "at least 1", "got": trees, "met": trees > 0}
    assert scene.theme == "park"
