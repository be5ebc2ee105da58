"""The documentation as a reader walks it: the front page leads to every page, links to pages."""

import re
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[1] / "docs"
PAGES = sorted(DOCS.rglob("*.md"))
PACKAGES = ("aeroscene", "autonomy", "flightsim", "scenarios", "tools")


def linked(text):
    """Pages of ours that a text links to, in its order."""
    return re.findall(r"\]\(([\w./]+\.md)[)#]", text)


def in_the_navigation():
    """Pages of the site's navigation, in its order."""
    nav = (DOCS.parent / "mkdocs.yml").read_text().partition("\nnav:\n")[2]
    return re.findall(r"[\w/]+\.md", nav)


def test_the_front_page_lists_the_pages_of_the_navigation_in_its_order():
    table = (DOCS / "index.md").read_text().partition("## All pages")[2]
    rows = [page for line in table.splitlines() if line.startswith("|") for page in linked(line)]
    assert rows == in_the_navigation()[1:]


def test_the_navigation_holds_every_page_once():
    there = [str(path.relative_to(DOCS)) for path in PAGES]
    assert sorted(in_the_navigation()) == sorted(there)


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.stem)
def test_a_page_links_to_pages_that_are_there(path):
    for page in linked(path.read_text()):
        assert (path.parent / page).is_file(), page


def test_the_testbench_has_one_spelling_and_the_other_is_named_once():
    root = DOCS.parent
    texts = [root / name for name in ("README.md", "CONTRIBUTING.md", "Makefile")]
    texts += [path for path in PAGES if path.name != "notebook.md"]
    texts += (root / "examples").glob("*.*")
    named = [path.name for path in texts for _ in re.findall("aeroscene-sitl", path.read_text())]
    assert named == ["index.md"]


def test_no_message_names_a_command_that_was_not_typed():
    root = DOCS.parent
    own = {root / "scenarios" / "cli" / name for name in ("__init__.py", "entry.py", "sitl.py")}
    sources = {path for name in PACKAGES for path in (root / name).rglob("*.py")} - own
    assert [path.name for path in sources if "aeroscene-sitl" in path.read_text()] == []
