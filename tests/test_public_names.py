"""The flat packages promise names that exist, cost nothing until used, and agree in all places."""

import ast
import importlib
import os
import re
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

from tests.scenarios.cli.test_without_torch import WITHOUT_TORCH

ROOT = Path(__file__).parents[1]
PACKAGES = ("aeroscene", "autonomy", "flightsim", "scenarios")
LAZY = ("aeroscene", "flightsim", "scenarios")
NEED_TORCH = {"Generator", "Request", "generate_scene"}
HEAVY = ("casadi", "llvmlite", "mujoco", "numba", "numpy", "rerun", "scipy", "shapely", "torch")


@pytest.mark.parametrize("package", PACKAGES)
def test_every_public_name_is_there_and_says_what_it_is(package):
    module = importlib.import_module(package)
    assert list(module.__all__) == sorted(set(module.__all__), key=module.__all__.index)
    for name in module.__all__:
        if name in NEED_TORCH and find_spec("torch") is None:
            continue
        value = getattr(module, name)
        assert name in dir(module)
        assert not callable(value) or value.__doc__, name


@pytest.mark.parametrize("package", LAZY)
def test_type_checkers_and_readers_are_told_the_same(package):
    tree = ast.parse((ROOT / package / "__init__.py").read_text())
    (branch,) = (node for node in tree.body if isinstance(node, ast.If))
    imports = [line for line in branch.body if isinstance(line, ast.ImportFrom)]
    imported = {alias.name for line in imports for alias in line.names} - {"*"}
    for line in imports:
        if line.names[0].name == "*":
            imported |= set(importlib.import_module(str(line.module)).__all__)
    assert sorted(imported) == sorted(importlib.import_module(package).__all__)


def test_the_door_has_every_public_name_of_the_others():
    door = importlib.import_module("aeroscene")
    for package in map(importlib.import_module, ("flightsim", "scenarios")):
        for name in package.__all__:
            assert name in door.__all__
            assert getattr(door, name) is getattr(package, name)
    names: dict[str, object] = {}
    exec("from aeroscene import *", names)
    assert {"Scene", "Plant", "Sitl", "make"} <= set(names)


def test_importing_the_packages_loads_nothing_heavy():
    code = (
        f"import sys, {', '.join(PACKAGES)};"
        f"print(*sorted(set(sys.modules) & set({HEAVY!r})), end='')"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == ""


@pytest.mark.parametrize("package", PACKAGES)
def test_every_folder_of_modules_is_a_package_that_the_import_rules_see(package):
    folders = {path.parent for path in (ROOT / package).rglob("*.py")}
    assert [str(path) for path in folders if not (path / "__init__.py").exists()] == []


def test_a_name_that_is_not_public_is_named():
    with pytest.raises(AttributeError, match="'flightsim' has no attribute 'plnt'"):
        importlib.import_module("flightsim").plnt  # noqa: B018


def snippets():
    """Code of the Python page, block by block."""
    page = (ROOT / "docs" / "python.md").read_text()
    return re.findall(r"```python\n(.*?)```", page, re.DOTALL)


def test_the_snippets_of_the_python_page_run_from_top_to_bottom(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    blocks = snippets()
    assert len(blocks) > 8
    names = {"__name__": "page"}
    for block in blocks:
        exec(compile(block, "docs/python.md", "exec"), names)
    assert Path("scene-7.json").exists() == (find_spec("torch") is not None)
    assert names["armed"].is_accepted
    assert names["result"].success, names["result"].reason
    assert len(names["track"]) * 0.02 == pytest.approx(names["result"].sim_seconds)
    assert names["hop"].success, names["hop"].reason
    assert names["plant"].time_us == 9_000_000
    assert names["plant"].truth.position_enu_m[2] > 0.3
    assert names["categories"]


def test_the_snippet_that_needs_torch_says_how_to_get_it(tmp_path):
    before, snippet = (block for block in snippets() if "write_scene" in block)
    opened = "from aeroscene import load_scene\nscene = load_scene('field')\n"
    done = subprocess.run(
        [sys.executable, "-c", f"{WITHOUT_TORCH}\n{opened}{before}{snippet}"],
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith(
        "the scene model needs torch, which is not installed: pip install 'aeroscene[model]'"
    )
    assert not (tmp_path / "scene-7.json").exists()


def test_the_page_links_every_example():
    page = (ROOT / "docs" / "python.md").read_text() + (ROOT / "examples" / "README.md").read_text()
    for path in (ROOT / "examples").glob("*.py"):
        assert path.name in page, path.name
