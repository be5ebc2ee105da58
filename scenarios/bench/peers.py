"""Hover environments of other projects beside ours, one environment at a time on one core.

Neither project is a dependency: each is measured where it is installed, with its own vehicle,
physics rate and reward. Their steps are not as long as ours, so simulated time is told too.
"""

from __future__ import annotations

import contextlib
import importlib
import importlib.util
import os
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from scenarios.bench.configs import BenchError, PeerName
from scenarios.bench.row import Row, higher

_WARM_UP_S = 1.0
"""Simulated time that is not counted: PyFlyt compiles its kernels meanwhile."""


class Peer(NamedTuple):
    """An environment with the interface of Gymnasium."""

    title: str
    step_hz: float
    """Steps of the environment in a simulated second."""
    make: Callable[[], Any]
    package: str
    source: str
    """Where the package comes from."""


def _pyflyt() -> Any:
    environments = importlib.import_module("PyFlyt.gym_envs.quadx_envs.quadx_hover_env")
    return environments.QuadXHoverEnv(agent_hz=40)


def _gym_pybullet_drones() -> Any:
    environments = importlib.import_module("gym_pybullet_drones.envs.HoverAviary")
    return environments.HoverAviary(ctrl_freq=48)


def _ours() -> Any:
    single = importlib.import_module("scenarios.environments.single")
    return single.AeroSceneEnv("hover")


# The rates nearest to our 50 Hz that divide the 120 Hz and the 240 Hz of their loops.
PEERS: Mapping[PeerName, Peer] = MappingProxyType(
    {
        "gym-pybullet-drones": Peer(
            "gym-pybullet-drones HoverAviary, rotor speeds",
            48.0,
            _gym_pybullet_drones,
            "gym_pybullet_drones",
            "the repository utiasDSL/gym-pybullet-drones",
        ),
        "pyflyt": Peer(
            "PyFlyt QuadXHover, body rates", 40.0, _pyflyt, "PyFlyt", "pip install PyFlyt"
        ),
    }
)
OURS = Peer("AeroScene/Hover-v0, one world, body rates", 50.0, _ours, "scenarios", "")


def check_installed(names: Sequence[PeerName]) -> None:
    """Refuse peers that are not installed.

    Raises:
        BenchError: Naming the first of them.
    """
    for name in names:
        if importlib.util.find_spec(PEERS[name].package) is None:
            raise _not_installed(PEERS[name], f"no module {PEERS[name].package}")


def peer_rows(names: Sequence[PeerName], seconds: float) -> Iterator[Row]:
    """Steps of our single environment, then of each peer, with the action in its box's middle.

    Args:
        names: The peers, keys of `PEERS`.
        seconds: Simulated time that each is stepped.

    Raises:
        BenchError: If one of them, or what it needs, is not installed.
    """
    for peer in (OURS, *(PEERS[name] for name in names)):
        try:
            with _quiet_stdout():
                cpu_s = stepping_s(peer, seconds)
        except ImportError as error:
            raise _not_installed(peer, str(error)) from None
        n_steps = round(seconds * peer.step_hz)
        unit = f"steps of {1e3 / peer.step_hz:.3g} ms / CPU s"
        yield higher(peer.title, n_steps / cpu_s, unit)
        yield higher(peer.title, seconds / cpu_s, "simulated s / CPU s")


def _not_installed(peer: Peer, why: str) -> BenchError:
    name = peer.title.split()[0]
    return BenchError(f"peers: {name} is not installed ({why}); valid: {peer.source}, or no peer")


def stepping_s(peer: Peer, seconds: float) -> float:
    """CPU seconds of an environment's steps, with a new episode where one ends.

    Args:
        peer: What makes it.
        seconds: Simulated time.

    Raises:
        ImportError: If it is not installed.
    """
    environment = peer.make()
    try:
        environment.reset(seed=0)
        space = environment.action_space
        action = (0.5 * (np.asarray(space.low) + np.asarray(space.high))).astype(space.dtype)
        _step(environment, action, round(_WARM_UP_S * peer.step_hz))
        return _step(environment, action, round(seconds * peer.step_hz))
    finally:
        environment.close()


def _step(environment: Any, action: np.ndarray, n: int) -> float:
    """CPU seconds of n steps, without those of resets: some build their world anew in each."""
    spent_s = 0.0
    for _ in range(n):
        begun_s = time.process_time()
        _, _, is_terminated, is_truncated, _ = environment.step(action)
        spent_s += time.process_time() - begun_s
        if is_terminated or is_truncated:
            environment.reset()
    return spent_s


@contextlib.contextmanager
def _quiet_stdout() -> Iterator[None]:
    """Send to stderr what Bullet's C++ writes to the standard output, which may be JSON."""
    sys.stdout.flush()
    kept = os.dup(1)
    os.dup2(2, 1)
    try:
        yield
    finally:
        sys.stdout.flush()
        os.dup2(kept, 1)
        os.close(kept)
