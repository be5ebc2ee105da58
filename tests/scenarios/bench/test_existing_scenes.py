"""What `aeroscene bench generate --scenes` says of scenes that are made already."""

import json
from dataclasses import replace

import pytest

from aeroscene.scene.io import write_scene
from scenarios.bench.configs import GenerateBenchCfg
from scenarios.bench.existing_scenes import rows
from scenarios.cli.main import main
from tests.aeroscene.conftest import SAMPLE, cached_scene
from tests.scenarios.small_corpus import write_corpus


@pytest.fixture(scope="module")
def corpus(tmp_path_factory):
    return write_corpus(tmp_path_factory.mktemp("corpus") / "corpus")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Six scenes as `aeroscene generate` writes them, the last without a landing area."""
    path = tmp_path_factory.mktemp("made")
    scenes = [cached_scene(index) for index in SAMPLE]
    scenes[-1] = replace(scenes[-1], interaction_areas=())
    for number, scene in enumerate(scenes):
        write_scene(scene, path / f"aeroscene-{number:04d}.json")
    return path


def judged(corpus, scenes, count=None, said=None):
    cfg = GenerateBenchCfg(scenes=str(scenes), count=count, seed=0, data=corpus)
    said = [] if said is None else said
    return {row.metric: row for row in rows(cfg, lambda *words: said.append(words))}


def test_scenes_of_a_folder_are_judged_beside_the_corpus(corpus, folder):
    said = []
    table = judged(corpus, folder, said=said)
    assert (table["scenes checked"].value, table["scenes checked"].unit) == (6, "of 6")
    assert table["scenes sound, after"].value == pytest.approx(500 / 6)
    assert not table["scenes sound, after"].is_met
    # Most of them are in the corpus.
    distance = table["distance to the nearest training scene, median, after"]
    assert distance.value == pytest.approx(0.0, abs=1e-9)
    truth = table["distance to the nearest training scene, median, test split"].value
    assert distance.target == 0.9 * truth
    assert table["skeletons that occur in training, after"].value > 50
    rate = table["collision rate, all pairs, after"]
    assert rate.target == table["collision rate, all pairs, test split"].value > 0
    assert table["layout MMD, after"].target is None
    assert "layout MMD, training split" in table
    assert not any(metric.endswith("before") for metric in table)
    mean = sum(len(cached_scene(index).objects) for index in SAMPLE) / len(SAMPLE)
    assert table["objects / scene, mean"].value == pytest.approx(mean)
    shares = [share for _, share in said]
    assert shares == sorted(shares)
    assert 0.0 == shares[0] < shares[-1] < 1.0


def test_a_dataset_is_judged_too(corpus):
    table = judged(corpus, corpus, count=5)
    assert table["scenes sound, after"].value == 100.0
    nearest = table["distance to the nearest training scene, median, after"]
    assert nearest.value == pytest.approx(0.0, abs=1e-9)


def test_the_command_judges_what_ships_and_says_so(corpus, capsys):
    args = ["--scenes", "shipped", "--count", "6", "--data", str(corpus), "--json"]
    # Averages of six scenes are not the paper's.
    assert main(["bench", "generate", *args]) == 1
    output = capsys.readouterr()
    assert "of the 1,016 scenes; aeroscene dataset build makes the others" in output.err
    report = json.loads(output.out)
    assert (report["bench"], report["scenes"], report["count"]) == ("generate", "shipped", 6)
    values = {row["metric"]: row["value"] for row in report["rows"]}
    assert values["scenes sound, after"] == 100.0
    assert values["skeletons that occur in training, after"] == 0.0
    assert values["distance to the nearest training scene, median, after"] > 0.2


@pytest.mark.parametrize(
    ("args", "says"),
    [
        (("--scenes", "nowhere"), "'nowhere' holds no dataset"),
        (("--scenes", "{folder}", "--count", "7"), "7 scenes of"),
        (("--scenes", "shipped", "--preset", "paper"), "made already"),
        (("--scenes", "shipped", "--checkpoint", "x"), "made already"),
        (("--scenes", "shipped", "--data", "{folder}"), "holds no dataset"),
    ],
)
def test_bad_input_ends_with_status_2_and_one_line(args, says, corpus, folder, capsys):
    args = [arg.format(folder=folder) for arg in args]
    if "--data" not in args:
        args += ["--data", str(corpus)]
    with pytest.raises(SystemExit) as stop:
        main(["bench", "generate", *args])
    assert stop.value.code == 2
    output = capsys.readouterr()
    assert output.out == ""
    (line,) = output.err.strip().splitlines()
    assert says in line
