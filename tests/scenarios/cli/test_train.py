"""`aeroscene train` as a user meets it."""

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from dataclasses import replace

import psutil
import pytest
import torch

from aeroscene.corpus.dataset import open_dataset, store_scene, write_manifest
from aeroscene.learning.training.batches.curation import scene_file
from aeroscene.learning.training.checkpoint import read_checkpoint
from aeroscene.learning.training.state_head import read_head
from aeroscene.scene.io import write_scene
from scenarios.cli.main import main
from tests.aeroscene.conftest import cached_scene
from tests.aeroscene.learning.training.test_data import layouts
from tests.scenarios.in_process import in_process

SCENES = (7, 42, 49)
TINY = """
[model]
width = 16
blocks = 2
heads = 2
[training]
batch_size = 2
warmup_steps = 2
[writer]
width = 8
kind_width = 4
layers = 1
[writer_training]
batch_size = 2
warmup_steps = 2
"""


@pytest.fixture(autouse=True)
def as_before():
    """The command sets these for its process, which is this one here."""
    threads = torch.get_num_threads()
    # A shell that starts the tests in the background has them ignore SIGINT.
    inherited = signal.signal(signal.SIGINT, signal.default_int_handler)
    handlers = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    yield
    torch.set_num_threads(threads)
    found = {number: signal.getsignal(number) for number in handlers}
    signal.signal(signal.SIGINT, inherited)
    assert found == handlers


@pytest.fixture(scope="module")
def corpus(tmp_path_factory):
    folder = tmp_path_factory.mktemp("data") / "corpus"
    (folder / "scenes").mkdir(parents=True)
    write_manifest(folder, [store_scene(folder, cached_scene(index)) for index in SCENES])
    return folder


@pytest.fixture(scope="module")
def config(tmp_path_factory):
    path = tmp_path_factory.mktemp("config") / "tiny.toml"
    path.write_text(TINY)
    return path


@pytest.fixture(scope="module")
def streaming(tmp_path_factory):
    path = tmp_path_factory.mktemp("config") / "streaming.toml"
    path.write_text(TINY.replace("[writer]", "scene_uses = 2\n[writer]", 1))
    return path


def command(corpus, config, out, *more):
    fixed = ("--data", corpus, "--config", config, "--out", out, "--threads", 1)
    return ["train", *map(str, fixed), *map(str, more)]


def run(capsys, args):
    return in_process(capsys, *args)


@pytest.fixture(scope="module")
def trained(corpus, config, tmp_path_factory):
    """A training of four steps, begun and ended in a process."""
    out = tmp_path_factory.mktemp("trained") / "out"
    assert main(command(corpus, config, out, "--steps", 4)) == 0
    return out


def half_built(corpus):
    """What is said of a corpus that has not all its scenes."""
    return (
        f"aeroscene train: folder {str(corpus)!r} holds {len(SCENES)} of the 1,016 scenes; "
        "aeroscene dataset build makes the others\n"
    )


def copied(folder, to):
    to.mkdir()
    for path in folder.iterdir():
        (to / path.name).write_bytes(path.read_bytes())
    return to


def test_training_leaves_checkpoint_state_log_and_curves(corpus, config, tmp_path, capsys):
    out = tmp_path / "out"
    status, text, errors = run(capsys, command(corpus, config, out, "--steps", 4, "--json"))
    assert status == 0
    assert errors == half_built(corpus)
    facts = json.loads(text)
    assert facts["done"]
    assert facts["steps"] == 4
    assert facts["checkpoint"] == str(out / "checkpoint.safetensors")
    names = {path.name for path in out.iterdir()}
    assert {"checkpoint.safetensors", "state.safetensors", "log.jsonl", "curves.png"} >= names
    assert set(read_checkpoint(out / "checkpoint.safetensors").parts) == {"writer", "denoiser"}


def test_resume_takes_the_steps_that_are_left(trained, corpus, config, tmp_path, capsys):
    out = copied(trained, tmp_path / "out")
    more = ("--steps", 6, "--resume", "--json")
    status, text, _ = run(capsys, command(corpus, config, out, *more))
    assert status == 0
    assert json.loads(text)["steps"] == 6
    whole = tmp_path / "whole"
    assert run(capsys, command(corpus, config, whole, "--steps", 4))[0] == 0
    assert (whole / "checkpoint.safetensors").exists()
    assert run(capsys, command(corpus, config, whole, "--steps", 6, "--resume"))[0] == 0
    left, right = (read_checkpoint(f / "checkpoint.safetensors").parts for f in (out, whole))
    for part, weights in left.items():
        assert all(torch.equal(value, right[part][name]) for name, value in weights.items())


def test_a_training_begins_with_another_models_weights(trained, corpus, config, tmp_path, capsys):
    losses = {}
    for name, more in {
        "random": (),
        "begun": ("--begin", trained / "checkpoint.safetensors"),
    }.items():
        args = command(corpus, config, tmp_path / name, "--steps", 1, "--json", *more)
        status, text, _ = run(capsys, args)
        assert status == 0
        losses[name] = json.loads(text)["writer_loss"]
    assert losses["begun"] < losses["random"]


def test_a_model_that_keeps_its_language_keeps_what_is_not_trained(
    trained, corpus, config, tmp_path, capsys
):
    begun = trained / "checkpoint.safetensors"
    out, fewer = tmp_path / "out", tmp_path / "fewer"
    shutil.copytree(corpus, fewer)
    dataset = open_dataset(fewer)
    entries = [entry for entry in dataset.entries if entry.index != 42]
    write_manifest(fewer, entries)
    args = command(fewer, config, out, "--steps", 1, "--parts", "writer", "--begin", begun)
    assert run(capsys, [*args, "--keep-language"])[0] == 0
    old, new = (read_checkpoint(each) for each in (begun, out / "checkpoint.safetensors"))
    assert new.facts.vocabulary == old.facts.vocabulary
    assert all(torch.equal(v, old.parts["denoiser"][k]) for k, v in new.parts["denoiser"].items())
    changed = new.parts["writer"]
    assert not all(torch.equal(v, old.parts["writer"][k]) for k, v in changed.items())


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (("--keep-language",), "keep_language is True; valid: with --begin"),
        (("--begin", "shipped"), "network of other sizes than"),
        (("--begin", "nowhere.safetensors"), "'nowhere.safetensors'"),
    ],
)
def test_a_model_that_cannot_be_begun_with_is_named_in_a_line(
    more, said, corpus, config, tmp_path, capsys
):
    out = tmp_path / "out"
    status, _, errors = run(capsys, command(corpus, config, out, "--steps", 1, *more))
    assert status == 2
    assert said in errors
    assert len(errors.splitlines()) <= 2
    assert not out.exists()


def test_the_papers_presets_have_no_language_to_keep(corpus, tmp_path, capsys):
    options = ["--preset", "paper", "--begin", "shipped", "--keep-language", "--steps", "1"]
    out = tmp_path / "out"
    status, _, errors = run(capsys, ["train", "--data", str(corpus), "--out", str(out), *options])
    assert status == 2
    assert "keep_language is True; valid: without it with preset paper" in errors


@pytest.mark.timeout(600)
def test_ctrl_c_saves_and_a_resume_goes_on(corpus, config, tmp_path):
    out = tmp_path / "out"
    args = command(corpus, config, out, "--steps", 1_000_000)
    # A shell's background job ignores Ctrl-C, and so would its children.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        process = subprocess.Popen(
            [sys.executable, "-m", "scenarios.cli.main", *args],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )
    finally:
        signal.signal(signal.SIGINT, before)
    log = out / "log.jsonl"
    try:
        while not (log.exists() and '"writer"' in log.read_text()):
            assert process.poll() is None, process.stderr.read()
            time.sleep(0.05)
        process.send_signal(signal.SIGINT)
        text, errors = process.communicate()
    finally:
        process.kill()
        process.communicate()
    assert process.returncode == 130, errors
    assert "stopped and saved; --resume goes on from here" in errors
    assert "Traceback" not in errors
    n_steps = int(re.search(r"writer ([\d,]+) steps", text)[1].replace(",", ""))
    found = read_checkpoint(out / "checkpoint.safetensors")
    assert found.facts.training["writer_steps"] == n_steps >= 25
    assert set(found.parts) == {"writer"}
    assert main(command(corpus, config, out, "--steps", n_steps + 2, "--resume")) == 0
    found = read_checkpoint(out / "checkpoint.safetensors")
    assert found.facts.training["writer_steps"] == n_steps + 2
    assert found.facts.training["steps"] == n_steps + 2
    assert set(found.parts) == {"writer", "denoiser"}


def with_scenes(out, last):
    """A folder to train in, where scenes of the stream lie already: known kinds, no waiting."""
    path = scene_file(out, 51)
    path.parent.mkdir(parents=True)
    for number in range(51, last):
        write_scene(replace(cached_scene(7), seed=number), scene_file(out, number))
    return out


@pytest.mark.timeout(600)
def test_streamed_training_is_the_same_with_any_workers_and_after_a_resume(
    corpus, streaming, tmp_path, capsys
):
    weights = []
    for name, runs in {
        "one": (("--steps", 6, "--stream", "--workers", 1),),
        "resumed": (
            ("--steps", 6, "--minutes", 1e-6, "--stream", "--workers", 2),
            ("--steps", 6, "--resume"),
        ),
    }.items():
        out = with_scenes(tmp_path / name, 64)
        for more in runs:
            status, _, errors = run(capsys, command(corpus, streaming, out, *more))
            assert (status, errors) == (0, half_built(corpus))
        found = read_checkpoint(out / "checkpoint.safetensors")
        assert found.facts.training["steps"] == 6
        assert found.facts.data.stream.endswith("from 50")
        weights.append(found.facts.digest)
        lines = [json.loads(line) for line in (out / "log.jsonl").read_text().splitlines()]
        told = [line for line in lines if "uses" in line][-1]
        assert (told["scenes"], told["skipped"]) == (3 + 5, 0)
        assert told["uses"] == pytest.approx(6 * 2 / 8)
    assert weights[0] == weights[1]


def is_there(group):
    """Whether a process of a group still runs: one that waits to be reaped has ended."""
    return any(
        process.info["status"] != psutil.STATUS_ZOMBIE and group_of(process.pid) == group
        for process in psutil.process_iter(["status"])
    )


def group_of(pid):
    try:
        return os.getpgid(pid)
    except (ProcessLookupError, PermissionError):
        return None


@pytest.mark.timeout(600)
def test_sigterm_to_all_processes_saves_and_leaves_none(corpus, config, tmp_path):
    out = with_scenes(tmp_path / "out", 150)
    args = command(corpus, config, out, "--steps", 1_000_000, "--stream", "--workers", 2)
    process = subprocess.Popen(
        [sys.executable, "-m", "scenarios.cli.main", *args],
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    log = out / "log.jsonl"
    try:
        while not (log.exists() and '"uses"' in log.read_text()):
            assert process.poll() is None, process.stderr.read()
            time.sleep(0.05)
        os.killpg(process.pid, signal.SIGTERM)
        _, errors = process.communicate()
        deadline_s = time.monotonic() + 60.0
        while is_there(process.pid):
            assert time.monotonic() < deadline_s
            time.sleep(0.05)
    finally:
        if is_there(process.pid):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()
    assert process.returncode == 130, errors
    assert "stopped and saved; --resume goes on from here" in errors
    assert "Traceback" not in errors
    assert read_head(out / "state.safetensors").steps > 0


def test_stream_that_cannot_be_is_refused(corpus, streaming, trained, tmp_path, capsys):
    def says(data, *more):
        return refused(capsys, command(data, streaming, tmp_path / "out", "--steps", 2, *more))

    assert "workers is 2 without --stream; valid: with it" in says(corpus, "--workers", 2)
    assert "workers 0 is out of range; valid: 1 to 512" in says(corpus, "--stream", "--workers", 0)
    rooms = layouts(tmp_path / "rooms.jsonl.gz", 2)
    assert "is a file of layouts, of which no grammar makes more" in says(rooms, "--stream")
    foreign = tmp_path / "foreign"
    shutil.copytree(corpus, foreign)
    manifest = foreign / "manifest.json"
    manifest.write_text(re.sub('"sources":"[0-9a-f]+"', '"sources":"0"', manifest.read_text()))
    assert "3 of 3 scenes in" in says(foreign, "--stream")
    out = copied(trained, tmp_path / "begun")
    args = ["train", "--data", corpus, "--out", out, "--steps", 9, "--resume", "--stream"]
    status, text, errors = run(capsys, args)
    assert (status, text) == (2, "")
    # The corpus is half-built all the same.
    note, error = errors.splitlines(keepends=True)
    assert note == half_built(corpus)
    assert "valid: none, with which the training" in error


def refused(capsys, args):
    """What the command says where it does not do what it is asked; always one line."""
    status, text, errors = run(capsys, args)
    assert (status, text) == (2, "")
    assert errors.startswith("aeroscene")
    assert errors.count("\n") == 1
    return errors


@pytest.mark.parametrize(
    ("more", "message"),
    [
        (("--device", "cuda:7"), "device 'cuda:7' is not there, valid here: auto, cpu"),
        (("--steps", 0), "steps 0 is out of range; valid: 1 to 1000000000"),
        (("--minutes", -1), "minutes -1.0 is out of range; valid: above 0 minutes"),
        (("--minutes", "nan"), "minutes nan is out of range; valid: above 0 minutes"),
        (("--threads", 0), "threads 0 is out of range; valid: 1 to 1024"),
        (("--save-minutes", 0), "save-minutes 0.0 is out of range; valid: above 0 minutes"),
        (("--resume",), "holds no training to resume (state.safetensors is missing)"),
        (("--preset", "best"), "preset 'best' is not valid; valid: "),
        (("--parts", "prior"), "parts is 'prior'; valid: writer, denoiser with preset default"),
        (("--take", "none.safetensors"), "checkpoint 'none.safetensors' cannot be read"),
    ],
)
def test_what_cannot_be_done_is_said_before_anything_is_written(
    corpus, config, tmp_path, capsys, more, message
):
    out = tmp_path / "out"
    assert message in refused(capsys, command(corpus, config, out, "--steps", 2, *more))
    assert not out.exists()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[training]\nbatch_size = -4", "batch_size -4 is out of range; valid: 1 to 2147483647"),
        ("[loss]\nparameterisation = 'y'", "parameterisation: Invalid enum value 'y'"),
        ("[model]\ndepth = 3", "model.depth is unknown; valid: denoiser"),
        ("[model", "is no TOML"),
    ],
)
def test_configuration_out_of_range_names_field_and_file(corpus, tmp_path, capsys, text, message):
    config = tmp_path / "bad.toml"
    config.write_text(text)
    errors = refused(capsys, command(corpus, config, tmp_path / "out", "--steps", 1))
    assert message in errors
    assert "bad.toml" in errors


def test_data_that_is_not_there_is_named(config, tmp_path, capsys):
    errors = refused(capsys, command(tmp_path / "none", config, tmp_path / "out", "--steps", 1))
    assert "holds no dataset" in errors


def test_training_that_is_there_is_not_overwritten(trained, corpus, config, tmp_path, capsys):
    out = copied(trained, tmp_path / "out")
    before = {path.name: path.read_bytes() for path in out.iterdir()}
    errors = refused(capsys, command(corpus, config, out, "--steps", 9))
    assert "holds a training already (8 steps in all); valid: --resume" in errors
    assert {path.name: path.read_bytes() for path in out.iterdir()} == before


def test_resume_with_another_configuration_or_preset_is_refused(trained, corpus, tmp_path, capsys):
    out = copied(trained, tmp_path / "out")
    other = tmp_path / "other.toml"
    other.write_text(TINY.replace("width = 16", "width = 32"))
    more = ("--steps", 9, "--resume")
    assert "([model] differs)" in refused(capsys, command(corpus, other, out, *more))
    same = tmp_path / "same.toml"
    same.write_text(TINY)
    errors = refused(capsys, command(corpus, same, out, *more, "--preset", "paper"))
    assert "preset is 'paper'; valid: 'default'" in errors


def test_truncated_state_says_what_to_do(trained, corpus, config, tmp_path, capsys):
    out = copied(trained, tmp_path / "out")
    state = out / "state.safetensors"
    state.write_bytes(state.read_bytes()[:5000])
    errors = refused(capsys, command(corpus, config, out, "--steps", 9, "--resume"))
    assert "is truncated or no state of a training" in errors
    assert "delete it to train anew" in errors


def test_paper_preset_trains_its_prior_first(corpus, tmp_path, capsys):
    config = tmp_path / "paper.toml"
    config.write_text(
        "[model]\nwidth = 16\nblocks = 2\nheads = 2\nunet_widths = [8, 8]\n"
        "[training]\nbatch_size = 2\nprior_steps = 2\n"
    )
    out = tmp_path / "out"
    args = command(corpus, config, out, "--steps", 2, "--preset", "paper", "--json")
    status, text, _ = run(capsys, args)
    assert status == 0
    assert json.loads(text)["preset"] == "paper"
    found = read_checkpoint(out / "checkpoint.safetensors")
    assert set(found.parts) == {"contents", "prior", "denoiser"}
    stages = [json.loads(line)["stage"] for line in (out / "log.jsonl").read_text().splitlines()]
    assert [*dict.fromkeys(stages)] == ["contents", "prior", "denoiser"]
