"""Kernels: all are compiled ahead, what will compile is announced, what is cached is not."""

import logging
import os
import subprocess
import sys
from pathlib import Path

import pytest

from autonomy.jit import announce_if_cold, cache_directory
from scenarios.run.kernels import (
    EXPLORING_MODULES,
    PILOT_MODULES,
    announce_pilot_kernels,
    compile_everything,
)

pytestmark = pytest.mark.timeout(600)  # run alone after an edit of kernels, these compile them all


def test_compiled_kernels_are_not_announced(caplog):
    steps = []
    compile_everything(lambda _, share: steps.append(share))
    assert steps == sorted(steps)
    caplog.clear()  # what was not in the cache before was announced
    with caplog.at_level(logging.WARNING):
        announce_pilot_kernels()
        announce_pilot_kernels("onboard")
    assert caplog.messages == []
    for module in (*PILOT_MODULES, *EXPLORING_MODULES):
        assert any(cache_directory(module).rglob("*.nbi")), module


def test_kernels_without_cached_code_are_announced_once(caplog, monkeypatch, tmp_path):
    monkeypatch.setenv("AEROSCENE_CACHE_DIR", str(tmp_path))
    cache_directory.cache_clear()
    try:
        with caplog.at_level(logging.WARNING):
            announce_if_cold(PILOT_MODULES, "the kernels", 3.0)
            announce_if_cold(PILOT_MODULES, "the kernels", 3.0)
    finally:
        cache_directory.cache_clear()
    assert caplog.messages == ["compiling the kernels, once, about 3 s"]


ROOT = Path(__file__).parents[3]
FORGOTTEN_KERNELS = """
import importlib
import sys
from pathlib import Path
from numba.core.dispatcher import Dispatcher
from scenarios.run.kernels import compile_everything

def parts(kernel):
    function = kernel.py_func
    found = (function.__globals__.get(name) for name in function.__code__.co_names)
    return {part for part in found if isinstance(part, Dispatcher)}

compile_everything(lambda *_: None)
assert "torch" not in sys.modules
kernels = set()
for package in ("aeroscene", "autonomy", "flightsim"):
    for path in Path(package).rglob("*.py"):
        if "\\n@kernel\\n" in path.read_text():
            module = importlib.import_module(".".join(path.with_suffix("").parts))
            kernels |= {value for value in vars(module).values() if isinstance(value, Dispatcher)}
# What was called, and what that calls: of a kept kernel the parts are not loaded again.
waiting = [kernel for kernel in kernels if kernel.overloads]
used = set(waiting)
while waiting:
    new = parts(waiting.pop()) - used
    used |= new
    waiting += new
print(len(used), *sorted(f"{k.__module__}.{k.__name__}" for k in kernels - used))
"""
ARRANGE = "from scenarios.run.kernels import arrange_once; arrange_once()"


def python(*args, **environment):
    return subprocess.run(
        [sys.executable, *args],
        env=os.environ | {"PYTHONPATH": str(ROOT)} | environment,
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )


def test_no_kernel_is_forgotten_and_none_needs_torch():
    n_used, *forgotten = python("-c", FORGOTTEN_KERNELS).stdout.split()
    assert int(n_used) > 200
    assert forgotten == []


def test_the_first_scene_compiles_nothing(tmp_path):
    cache = {"AEROSCENE_CACHE_DIR": str(tmp_path)}
    python("-c", ARRANGE, **cache)
    kept = {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*.nb?")}
    assert len(kept) == 8  # an index and the code of each of four
    scenes = ("--seed", "42", "--count", "2", "--objects", "60", "--steps", "4")
    scenes += ("--out", str(tmp_path / "scenes"))
    python("-m", "aeroscene", "generate", *scenes, **cache)
    assert {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*.nb?")} == kept
