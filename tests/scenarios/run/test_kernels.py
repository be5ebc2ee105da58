"""Kernels of our pilot: what will compile is announced, what is cached is not."""

import logging

from autonomy.jit import announce_if_cold, cache_directory
from scenarios.run.kernels import (
    EXPLORING_MODULES,
    PILOT_MODULES,
    announce_pilot_kernels,
    compile_everything,
)


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
    monkeypatch.setattr("platformdirs.user_cache_dir", lambda _: str(tmp_path))
    cache_directory.cache_clear()
    try:
        with caplog.at_level(logging.WARNING):
            announce_if_cold(PILOT_MODULES, "the kernels", 3.0)
            announce_if_cold(PILOT_MODULES, "the kernels", 3.0)
    finally:
        cache_directory.cache_clear()
    assert caplog.messages == ["compiling the kernels, once, about 3 s"]
