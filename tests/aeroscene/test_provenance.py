import pytest

from aeroscene.provenance import sources_digest


@pytest.fixture
def package(tmp_path):
    for name in ("scene.py", "curation/streets.py", "dataset.py", "layouts/neutral.py"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text("x = 1\n")
    return tmp_path


@pytest.mark.parametrize(
    ("name", "is_part"),
    [
        ("scene.py", True),
        ("curation/streets.py", True),
        ("curation/new.py", True),
        ("dataset.py", False),
        ("layouts/neutral.py", False),
        ("curation/notes.txt", False),
    ],
)
def test_the_digest_changes_with_what_makes_scenes_and_with_nothing_else(package, name, is_part):
    before = sources_digest(package)
    (package / name).write_text("x = 2\n")
    assert (sources_digest(package) != before) is is_part


def test_the_digest_changes_when_a_source_is_renamed(package):
    before = sources_digest(package)
    (package / "curation/streets.py").rename(package / "curation/roads.py")
    assert sources_digest(package) != before
