"""The documentation as a reader walks it: the front page leads to every page, links to pages."""

import re
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[1] / "docs"
PAGES = sorted(DOCS.rglob("*.md"))


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
