"""The dataset's folder: what is written is what is read, and what is damaged is named."""

import pytest

from aeroscene.corpus.curation import curate_scene
from aeroscene.corpus.dataset import (
    JOURNAL,
    MANIFEST,
    DatasetError,
    is_whole,
    journal_line,
    open_dataset,
    read_entries,
    store_scene,
    write_manifest,
)
from aeroscene.scene import SceneError
from tests.aeroscene.conftest import cached_scene

INDICES = (40, 42, 7)


@pytest.fixture(scope="module")
def stored(tmp_path_factory):
    folder = tmp_path_factory.mktemp("corpus")
    (folder / "scenes").mkdir()
    entries = [store_scene(folder, cached_scene(index)) for index in INDICES]
    return folder, entries


@pytest.fixture
def folder(stored, tmp_path):
    """A folder of one's own to damage."""
    for path in (stored[0] / "scenes").iterdir():
        (tmp_path / "scenes").mkdir(exist_ok=True)
        (tmp_path / "scenes" / path.name).write_bytes(path.read_bytes())
    write_manifest(tmp_path, stored[1])
    return tmp_path


def test_scenes_come_back_equal_and_in_the_order_of_their_numbers(folder):
    dataset = open_dataset(folder)
    assert [entry.index for entry in dataset.entries] == sorted(INDICES)
    assert list(dataset.scenes()) == [cached_scene(index) for index in sorted(INDICES)]


def test_the_manifest_says_what_is_in_a_scene(folder):
    entry = open_dataset(folder).select({42}).entries[0]
    scene = cached_scene(42)
    assert entry.domain == scene.domain == "mixed"
    assert entry.n_coarse + entry.n_fine == entry.n_objects == len(scene.objects)
    assert entry.n_landing == len(scene.landing_areas)
    assert entry.n_landing + entry.n_perching == len(scene.interaction_areas)
    assert is_whole(folder, entry)


def test_splits_are_parts(folder):
    dataset = open_dataset(folder)
    assert [entry.index for entry in dataset.of_split("test").entries] == [40]
    assert [entry.index for entry in dataset.of_split("train").entries] == [7, 42]


def test_the_manifest_does_not_depend_on_the_order_in_which_scenes_were_made(folder, stored):
    before = (folder / MANIFEST).read_bytes()
    write_manifest(folder, reversed(stored[1]))
    assert (folder / MANIFEST).read_bytes() == before


def test_storing_a_scene_again_gives_the_same_bytes(folder):
    path = folder / "scenes" / "corpus-0007.json.gz"
    before = path.read_bytes()
    store_scene(folder, curate_scene(7))
    assert path.read_bytes() == before
    assert [p.name for p in folder.rglob(".*")] == []


def test_a_build_that_was_killed_is_read_as_far_as_its_journal_goes(folder, stored):
    (folder / MANIFEST).unlink()
    lines = [journal_line(entry) for entry in stored[1]]
    (folder / JOURNAL).write_bytes(b"".join(lines)[:-20])
    assert {entry.index for entry in read_entries(folder)} == set(INDICES[:-1])


@pytest.mark.parametrize(
    ("damage", "says"),
    [
        (lambda path: path.unlink(), "no such file"),
        (lambda path: path.write_bytes(path.read_bytes()[:-500]), "cut short"),
        (lambda path: path.write_bytes(b""), "not JSON"),
        (
            lambda path: path.write_bytes(path.with_name("corpus-0007.json.gz").read_bytes()),
            "another sha256",
        ),
    ],
)
def test_a_damaged_scene_is_named(folder, damage, says):
    dataset = open_dataset(folder).select({42})
    damage(folder / "scenes" / "corpus-0042.json.gz")
    assert not is_whole(folder, dataset.entries[0])
    with pytest.raises(SceneError, match=f"corpus-0042.json.gz.*{says}") as caught:
        list(dataset.scenes())
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda text: text[:200], "damaged"),
        (lambda text: text.replace('"version":1', '"version":9'), "version 9.*version 1"),
        (lambda text: text.replace("aeroscene-dataset", "coco"), "'coco'"),
        (lambda text: text.replace("scenes/corpus-0042", "../corpus-0042"), "file"),
        (lambda text: text.replace('"n_fine":', '"n_fin":', 1), "n_fin"),
    ],
)
def test_a_manifest_that_is_none_of_ours_is_named_with_its_fault(folder, change, says):
    path = folder / MANIFEST
    path.write_text(change(path.read_text()))
    with pytest.raises(DatasetError, match=f"{MANIFEST}.*{says}"):
        open_dataset(folder)


def test_a_folder_without_a_dataset_says_what_would_be_one(tmp_path):
    with pytest.raises(DatasetError, match="aeroscene dataset build"):
        open_dataset(tmp_path)
    with pytest.raises(DatasetError, match="holds no dataset"):
        open_dataset(tmp_path / "absent")
    (tmp_path / "file").write_text("x")
    with pytest.raises(DatasetError, match="is a file"):
        open_dataset(tmp_path / "file")
