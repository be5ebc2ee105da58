"""Kernels where nothing can be kept: they compile and run, and one line says why."""

import logging
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from aeroscene.files import cache_folder
from autonomy.kernel_cache import cache_root

ROOT = Path(__file__).parents[2]
KERNELS = """
import logging
logging.basicConfig(format="%(message)s")
from autonomy import jit

@jit.kernel
def double(x):
    return 2.0 * x

@jit.kernel
def triple(x):
    return 3.0 * x

jit.compile_ahead(double, (1.0,), "the doubler", 3.0)
print(double(2.0), triple(1.0), len(double.stats.cache_hits))
"""


@pytest.fixture
def spoken():
    """The logger of the one line, as before anybody spoke."""
    logger = logging.getLogger("aeroscene.cache")
    before, logger.disabled = logger.disabled, False
    yield logger
    logger.disabled = before


def run(folder, **environment):
    """Run the kernels in a process of its own: what it prints and what it says."""
    (folder / "craft.py").write_text(KERNELS)
    done = subprocess.run(
        [sys.executable, "-c", "import craft"],
        env={"PATH": os.environ["PATH"], "PYTHONPATH": f"{folder}:{ROOT}", **environment},
        cwd=folder,
        capture_output=True,
        text=True,
        check=True,
    )
    return done.stdout.split(), done.stderr.splitlines()


def test_a_cache_that_cannot_be_written_costs_one_line(tmp_path):
    (tmp_path / "file").write_text("")
    cache = tmp_path / "file" / "cache"
    printed, said = run(tmp_path, AEROSCENE_CACHE_DIR=str(cache))
    assert printed == ["4.0", "3.0", "0"]
    announced, line = said
    assert announced == "compiling the doubler, about 3 s"
    assert line == (
        f"no cache, kernels compile anew in each run: {cache}: not a directory; "
        "set AEROSCENE_CACHE_DIR to a folder that can be written"
    )


def test_a_home_that_is_no_folder_costs_one_line(tmp_path):
    printed, said = run(tmp_path, HOME="/dev/null")
    assert printed == ["4.0", "3.0", "0"]
    assert len(said) == 2
    assert "/dev/null" in said[1]


def test_the_named_folder_keeps_all_kernels(tmp_path):
    cache = tmp_path / "cache"
    for n_hits in ("0", "1"):
        printed, said = run(tmp_path, AEROSCENE_CACHE_DIR=str(cache), HOME="/dev/null")
        assert printed[2] == n_hits
    assert said == []
    assert {path.name for path in cache.iterdir()} == {"kernels"}
    assert len(list(cache.rglob("*.nbi"))) == 2


def test_a_copy_of_our_packages_finds_the_code_that_another_has_compiled(tmp_path):
    """For example a fresh clone, in which tests would wait for two minutes of compilation."""
    ask = (
        "from autonomy import rotation;"
        "rotation.wrap_angle(1.0);"
        "print(rotation.__file__, len(rotation.wrap_angle.stats.cache_hits))"
    )
    environment = {"PATH": os.environ["PATH"], "AEROSCENE_CACHE_DIR": str(tmp_path / "cache")}
    for place, n_hits in (("here", 0), ("there", 1), ("elsewhere", 0)):
        copy = tmp_path / place / "autonomy"
        copy.mkdir(parents=True)
        (copy / "__init__.py").write_text("")
        for name in ("jit", "kernel_cache", "rotation"):
            shutil.copy(ROOT / "autonomy" / f"{name}.py", copy)
        if place == "elsewhere":
            source = (copy / "rotation.py").read_text()
            (copy / "rotation.py").write_text(f"{source}\n# changed\n")
        done = subprocess.run(
            [sys.executable, "-c", ask],
            env=environment | {"PYTHONPATH": str(copy.parent)},
            cwd=copy.parent,
            capture_output=True,
            text=True,
            check=True,
        )
        assert done.stdout.split() == [str(copy / "rotation.py"), str(n_hits)]


def test_a_warm_cache_is_read_where_nothing_can_be_written(tmp_path, monkeypatch, spoken, caplog):
    """Such as that of an image whose root is mounted read-only."""
    from autonomy import jit  # with its folder patched

    def refuse(*_args, **_kwargs):
        raise OSError(30, "Read-only file system")

    monkeypatch.setenv("AEROSCENE_CACHE_DIR", str(tmp_path))
    monkeypatch.delenv("AEROSCENE_CACHE", raising=False)
    jit.cache_directory.cache_clear()
    try:
        warm = _double()
        warm(1.0)
        monkeypatch.setattr(tempfile, "TemporaryFile", refuse)
        again = _double()
        assert again(1.0) == 2.0
        assert again.stats.cache_hits
        assert not caplog.messages
        assert again(1) == 2  # Integers were not compiled before.
        assert again(True) == 2
    finally:
        jit.cache_directory.cache_clear()
    (line,) = caplog.messages
    assert f"{tmp_path}: read-only file system" in line


def _double():
    from autonomy.jit import kernel

    @kernel
    def double(x):
        return 2.0 * x

    return double


@pytest.mark.parametrize(
    ("environment", "expected"),
    [
        ({"AEROSCENE_CACHE_DIR": "/a/b"}, Path("/a/b")),
        ({"AEROSCENE_CACHE_DIR": "here"}, Path.cwd() / "here"),
        ({"AEROSCENE_CACHE": "off", "AEROSCENE_CACHE_DIR": "/a/b"}, None),
        ({"XDG_CACHE_HOME": "/c"}, Path("/c/aeroscene")),
    ],
)
def test_one_rule_names_the_folder_for_everything(monkeypatch, environment, expected):
    """`aeroscene.files` has the rule too, because `autonomy.kernel_cache` loads numba."""
    for name in ("AEROSCENE_CACHE", "AEROSCENE_CACHE_DIR", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    if "XDG_CACHE_HOME" in environment and sys.platform == "darwin":
        pytest.skip("macOS has a folder of its own")
    assert cache_root() == expected
    assert cache_folder("x") == (None if expected is None else expected / "x")


def test_a_user_without_a_home_folder_has_no_cache(monkeypatch):
    """Neither HOME nor an entry in the user database, as `docker run --user 4242` gives one."""
    for name in ("AEROSCENE_CACHE", "AEROSCENE_CACHE_DIR", "XDG_CACHE_HOME", "HOME"):
        monkeypatch.delenv(name, raising=False)

    def unknown(uid):
        raise KeyError(uid)

    monkeypatch.setattr("pwd.getpwuid", unknown)
    assert cache_root() is None
    assert cache_folder("fields") is None
