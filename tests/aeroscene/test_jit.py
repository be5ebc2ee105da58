"""Kept machine code of kernels."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numba

from aeroscene.jit import kernel

CALLEE = "from aeroscene.jit import kernel\n\n@kernel\ndef step(x):\n    return x + {}\n"
CALLER = """
from aeroscene.jit import kernel
from kernels_of_test.{}

@kernel
def twice(x):
    return step(step(x))

print(twice(1.0), twice.stats.cache_hits)
"""


def _result(folder: Path) -> str:
    path = os.pathsep.join([str(folder), *sys.path])
    done = subprocess.run(
        [sys.executable, "-c", "import kernels_of_test.caller"],
        env=os.environ | {"PYTHONPATH": path, "AEROSCENE_CACHE_DIR": str(folder / "cache")},
        capture_output=True,
        text=True,
        check=True,
    )
    return done.stdout.strip()


def test_change_of_a_callee_in_another_file_leads_to_fresh_code(tmp_path):
    package = tmp_path / "kernels_of_test"
    package.mkdir()
    (package / "__init__.py").touch()
    for imports in ("callee import step", "middle import step"):
        (package / "caller.py").write_text(CALLER.format(imports))
        (package / "middle.py").write_text("from kernels_of_test.callee import step as step\n")
        (package / "callee.py").write_text(CALLEE.format(1))
        _result(tmp_path)
        # Kept: nothing is compiled, and nothing has changed.
        assert _result(tmp_path).split() == ["3.0", "Counter({(float64,):", "1})"]
        (package / "callee.py").write_text(CALLEE.format(5))
        assert _result(tmp_path).split()[0] == "11.0"


def test_settings_of_numba_stay_as_they_are():
    before = numba.config.CACHE_DIR

    @kernel
    def half(x):
        return x / 2

    assert half(3.0) == 1.5
    assert before == numba.config.CACHE_DIR


def test_no_kernel_is_compiled_by_any_other_way():
    package = Path(__file__).parents[2] / "aeroscene"
    assert [p.name for p in package.rglob("*.py") if "njit" in p.read_text()] == ["jit.py"]
