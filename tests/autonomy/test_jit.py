"""The kernels' cache notices every change; the message comes once."""

import importlib
import logging
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from autonomy import jit


@pytest.fixture
def fresh_tree(tmp_path, monkeypatch):
    """An empty source tree and an empty user cache."""
    source, cache = tmp_path / "source", tmp_path / "cache"
    source.mkdir()
    monkeypatch.setattr(jit, "_ROOT", source)
    monkeypatch.setenv("AEROSCENE_CACHE_DIR", str(cache))
    monkeypatch.delenv("AEROSCENE_CACHE", raising=False)
    forget()
    yield source
    forget()


def forget():
    jit.cache_directory.cache_clear()
    jit._imported.cache_clear()
    jit._bytes_of.cache_clear()
    jit._path_of.cache_clear()


def directory_of(module):
    forget()
    return jit.cache_directory(module)


def test_cache_moves_when_a_module_called_by_a_called_module_changes(fresh_tree):
    package = fresh_tree / "craft"
    package.mkdir()
    (package / "__init__.py").write_text("")
    (package / "outer.py").write_text("from craft.middle import f\n")
    (package / "middle.py").write_text("import math\nfrom craft.inner import g\n")
    (package / "inner.py").write_text("def g(): return 1\n")
    (package / "bystander.py").write_text("x = 1\n")
    before = directory_of("craft.outer")
    (package / "bystander.py").write_text("x = 2\n")
    assert directory_of("craft.outer") == before
    (package / "inner.py").write_text("def g(): return 2\n")
    assert directory_of("craft.outer") != before


@pytest.mark.parametrize(
    "line",
    [
        "import craft.inner",
        "import math, craft.inner as inner",
        "from craft import inner",
        "from craft import (  # noqa\n    other as o,\n    inner,  # last\n)",
        "def f():\n    from craft import inner  # late",
    ],
)
def test_cache_moves_however_the_changed_module_is_imported(fresh_tree, line):
    package = fresh_tree / "craft"
    package.mkdir()
    for name, source in (("__init__", ""), ("outer", line), ("inner", "x = 1"), ("other", "")):
        (package / f"{name}.py").write_text(f"{source}\n")
    before = directory_of("craft.outer")
    (package / "inner.py").write_text("x = 2\n")
    assert directory_of("craft.outer") != before


def test_old_caches_are_forgotten(fresh_tree, tmp_path):
    root = tmp_path / "cache" / "kernels" / "craft"
    for i in range(9):
        (root / f"old{i}").mkdir(parents=True)
    (fresh_tree / "craft.py").write_text("x = 1\n")
    directory_of("craft")
    assert 0 < len(list(root.iterdir())) < 9


def test_compilation_is_announced_once_and_gives_the_kernel(fresh_tree, monkeypatch, caplog):
    (fresh_tree / "craft.py").write_text(
        "from autonomy.jit import kernel\n\n\n@kernel\ndef double(x):\n    return 2.0 * x\n"
    )
    monkeypatch.syspath_prepend(fresh_tree)
    for _ in range(2):
        monkeypatch.delitem(sys.modules, "craft", raising=False)
        double = importlib.import_module("craft").double
        with caplog.at_level(logging.WARNING):
            jit.compile_ahead(double, (1.0,), "the doubler", 3.0)
    assert [record.getMessage() for record in caplog.records] == [
        "compiling the doubler, once, about 3 s"
    ]
    assert double(np.pi) == 2.0 * np.pi
    assert double.stats.cache_hits  # the second time it came from the disk


def test_making_a_kernel_leaves_numbas_setting_as_it_was(fresh_tree):
    (fresh_tree / "craft.py").write_text("x = 1\n")
    before = jit.config.CACHE_DIR

    def double(x):
        return 2 * x

    double.__module__ = "craft"
    compiled = jit.kernel(double)
    assert before == jit.config.CACHE_DIR
    assert jit.cache_directory("craft") in Path(compiled._cache._cache_path).parents


@pytest.mark.parametrize("package", ["aeroscene", "autonomy", "flightsim", "scenarios"])
def test_every_kernel_is_kept_under_a_digest_of_its_own(package):
    root = Path(jit.__file__).parents[1] / package
    own = Path(jit.__file__)
    bare = [path for path in root.rglob("*.py") if path != own and "njit" in path.read_text()]
    assert bare == []


def test_only_a_kernel_whose_code_is_asked_for_looks_through_its_sources(fresh_tree, monkeypatch):
    """A flight imports 125 kernels and asks for three."""
    (fresh_tree / "craft.py").write_text(
        "from autonomy.jit import kernel\n\n\n@kernel\ndef double(x):\n    return 2.0 * x\n"
    )
    monkeypatch.syspath_prepend(fresh_tree)
    monkeypatch.delitem(sys.modules, "craft", raising=False)
    double = importlib.import_module("craft").double
    assert jit.cache_directory.cache_info().currsize == 0
    jit.compile_ahead(double, (1.0,), "the doubler", 3.0)
    assert jit.cache_directory.cache_info().currsize == 1


def test_kernels_load_without_scipys_linear_algebra_and_still_have_it(tmp_path):
    """numba looks for it by importing it, a tenth of a launch."""
    (tmp_path / "craft.py").write_text(
        "import sys\n"
        "import numpy as np\n"
        "from autonomy import jit\n\n\n"
        "@jit.kernel\n"
        "def double(x):\n"
        "    return 2.0 * x\n\n\n"
        "@jit.kernel\n"
        "def inner(a, b):\n"
        "    return np.dot(a, b)\n\n\n"
        "jit.compile_ahead(double, (1.0,), 'the doubler', 3.0)\n"
        "print('scipy.linalg' in sys.modules, inner(np.arange(3.0), np.ones(3)))\n"
        "print('scipy.linalg' in sys.modules)\n"
    )
    environment = {
        **os.environ,
        "AEROSCENE_CACHE_DIR": str(tmp_path / "cache"),
        "PYTHONPATH": str(Path(jit.__file__).parents[1]),
    }
    printed = subprocess.run(
        [sys.executable, "-c", "import craft"],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    assert printed.split() == ["False", "3.0", "True"]
