"""Hover environments of other projects beside ours, one at a time and many at once.

None of the projects is a dependency. Each is measured if it is installed, started as its
documentation does, with its own vehicle and reward. Their physics runs at our 500 Hz if they allow
it. If a step is not as long as ours, compare physics steps and simulated time instead of steps.
"""

from __future__ import annotations

import contextlib
import functools
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
"""Simulated time that is not counted, because some projects compile their kernels meanwhile."""
_N_TOGETHER = 64


class Peer(NamedTuple):
    """An environment with the interface of Gymnasium."""

    title: str
    step_hz: float
    """Steps of the environment in a simulated second."""
    physics_hz: float
    make: Callable[[], Any]
    package: str
    source: str
    """Command or repository from which the package can be installed."""
    n_worlds: int = 1
    """Number of environments that are stepped together; more than one reset themselves."""


def _pyflyt() -> Any:
    environments = importlib.import_module("PyFlyt.gym_envs.quadx_envs.quadx_hover_env")
    return environments.QuadXHoverEnv(agent_hz=40)


def _gym_pybullet_drones() -> Any:
    environments = importlib.import_module("gym_pybullet_drones.envs.HoverAviary")
    return environments.HoverAviary(pyb_freq=500, ctrl_freq=50)


def _crazyflow(n_worlds: int) -> Any:
    environments = importlib.import_module("crazyflow.envs.reach_pos_env")
    return environments.ReachPosEnv(num_envs=n_worlds, freq=50, device="cpu")


def _ours() -> Any:
    single = importlib.import_module("scenarios.environments.single")
    return single.AeroSceneEnv("hover")


def _ours_together() -> Any:
    vector = importlib.import_module("scenarios.environments.vector")
    return vector.AeroSceneVectorEnv("hover", _N_TOGETHER, n_threads=1)


PEERS: Mapping[PeerName, tuple[Peer, ...]] = MappingProxyType(
    {
        "gym-pybullet-drones": (
            Peer(
                "gym-pybullet-drones HoverAviary, rotor speeds",
                50.0,
                500.0,
                _gym_pybullet_drones,
                "gym_pybullet_drones",
                "the repository utiasDSL/gym-pybullet-drones",
            ),
        ),
        "pyflyt": (
            Peer(
                "PyFlyt QuadXHover, body rates",
                # The rate nearest to ours that divides the 120 Hz of its loop.
                40.0,
                240.0,
                _pyflyt,
                "PyFlyt",
                "pip install PyFlyt",
            ),
        ),
        "crazyflow": tuple(
            Peer(
                f"crazyflow ReachPosEnv on CPU, attitude, {n_worlds} together",
                50.0,
                500.0,
                functools.partial(_crazyflow, n_worlds),
                "crazyflow",
                "pip install crazyflow, and SCIPY_ARRAY_API=1 in the environment",
                n_worlds,
            )
            for n_worlds in (1, _N_TOGETHER)
        ),
    }
)
OURS = (
    Peer("AeroScene/Hover-v0, body rates", 50.0, 500.0, _ours, "scenarios", ""),
    Peer(
        f"AeroScene/Hover-v0, body rates, {_N_TOGETHER} together",
        50.0,
        500.0,
        _ours_together,
        "scenarios",
        "",
        _N_TOGETHER,
    ),
)


def check_installed(names: Sequence[PeerName]) -> None:
    """Refuse peers that are not installed, before anything is measured.

    Args:
        names: Peers, keys of `PEERS`.

    Raises:
        BenchError: Naming the first peer that is missing.
    """
    for name in names:
        first = PEERS[name][0]
        if importlib.util.find_spec(first.package) is None:
            raise _unavailable(first, f"no module {first.package}")


def peer_rows(names: Sequence[PeerName], seconds: float) -> Iterator[Row]:
    """Step our environments, then each peer's, with the action in the middle of its box.

    Args:
        names: Peers, keys of `PEERS`.
        seconds: Simulated time that each environment is stepped.

    Raises:
        BenchError: If one of them, or what it needs, is not installed or does not start.
    """
    for peer in (*OURS, *(peer for name in names for peer in PEERS[name])):
        try:
            with _quiet_stdout():
                cpu_s = stepping_s(peer, seconds)
        except (ImportError, RuntimeError) as error:
            raise _unavailable(peer, str(error)) from None
        sim_s = peer.n_worlds * seconds
        unit = f"steps of {1e3 / peer.step_hz:.3g} ms / CPU s"
        yield higher(peer.title, sim_s * peer.step_hz / cpu_s, unit)
        yield higher(peer.title, sim_s * peer.physics_hz / cpu_s, "physics steps / CPU s")
        yield higher(peer.title, sim_s / cpu_s, "simulated s / CPU s")


def _unavailable(peer: Peer, why: str) -> BenchError:
    name = peer.title.split()[0]
    reason = " ".join(why.split())
    return BenchError(f"peers: {name} cannot be had ({reason}); valid: {peer.source}, or no peer")


def stepping_s(peer: Peer, seconds: float) -> float:
    """Return the CPU seconds of an environment's steps; ended episodes are begun anew.

    Args:
        peer: Environment to make and step.
        seconds: Simulated time.

    Raises:
        ImportError: If it is not installed.
    """
    environment = peer.make()
    try:
        environment.reset(seed=0)
        space = environment.action_space
        action = (0.5 * (np.asarray(space.low) + np.asarray(space.high))).astype(space.dtype)
        step = _step if peer.n_worlds == 1 else _step_together
        step(environment, action, round(_WARM_UP_S * peer.step_hz))
        return step(environment, action, round(seconds * peer.step_hz))
    finally:
        environment.close()


def _step(environment: Any, action: np.ndarray, n: int) -> float:
    """Return the CPU seconds of n steps without resets, in which some build their world anew."""
    spent_s = 0.0
    for _ in range(n):
        begun_s = time.process_time()
        _, _, is_terminated, is_truncated, _ = environment.step(action)
        spent_s += time.process_time() - begun_s
        if is_terminated or is_truncated:
            environment.reset()
    return spent_s


def _step_together(environment: Any, action: np.ndarray, n: int) -> float:
    """Return the CPU seconds of n steps of many environments, which reset themselves."""
    reward: Any = None
    begun_s = time.process_time()
    for _ in range(n):
        reward = environment.step(action)[1]
    # Some compute asynchronously, as JAX does, so the last result is read before the clock.
    np.asarray(reward)
    return time.process_time() - begun_s


@contextlib.contextmanager
def _quiet_stdout() -> Iterator[None]:
    """Redirect standard output to standard error.

    Bullet's C++ code writes to standard output, which may carry our JSON.
    """
    sys.stdout.flush()
    # By file descriptors, since C++ does not write through `sys.stdout`.
    kept = os.dup(1)
    os.dup2(2, 1)
    try:
        yield
    finally:
        sys.stdout.flush()
        os.dup2(kept, 1)
        os.close(kept)
