import pytest

from aeroscene.corpus.provenance import sources_digest


@pytest.fixture
def package(tmp_path):
    for name in (
        "scene/scene.py",
        "corpus/curation/streets.py",
        "corpus/dataset.py",
        "layouts/neutral_format.py",
    ):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("x = 1\n")
    return tmp_path


@pytest.mark.parametrize(
    ("name", "is_part"),
    [
        ("scene/scene.py", True),
        ("corpus/curation/streets.py", True),
        ("corpus/curation/new.py", True),
        ("corpus/dataset.py", False),
        ("layouts/neutral_format.py", False),
        ("corpus/curation/notes.txt", False),
    ],
)
def test_the_digest_changes_with_what_makes_scenes_and_with_nothing_else(package, name, is_part):
    before = sources_digest(package)
    (package / name).write_text("x = 2\n")
    assert (sources_digest(package) != before) is is_part


def test_the_digest_changes_when_a_source_is_renamed(package):
    before = sources_digest(package)
    (package / "corpus/curation/streets.py").rename(package / "corpus/curation/roads.py")
    assert sources_digest(package) != before
