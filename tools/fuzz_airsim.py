"""Hostile MessagePack-RPC against a run with --airsim.

    python tools/fuzz_airsim.py --messages 1000000

Clients send calls with wild arguments and bytes that are no calls, and vanish in the middle of
messages, while the simulation goes on. Every second an honest client must be answered. Prints a
JSON row. The exit status is 1 if a fault of ours has answered a call, or if memory grows.
"""

from __future__ import annotations

import argparse
import json
import random
import socket
import sys
import time
from typing import Any

import msgspec
import psutil
from fuzzing.rpc import RpcTraffic

from flightsim.testbench import TestbenchCfg
from scenarios.airsim.door import AirsimDoor
from scenarios.run.cfg import SitlCfg
from scenarios.run.sitl import Sitl

MOST_GROWTH_MB = 50.0
_N_CLIENTS, _A_TICK = 8, 100
_CHECK_EVERY = 50
_READ_BYTES = 1 << 20


class SilentError(Exception):
    """An honest client is no longer answered."""


class Siege:
    """A run under fire from several clients."""

    def __init__(self, sitl: Sitl, seed: int) -> None:
        """Attack the door of a run."""
        door = sitl.bench.simulator.interlude
        assert isinstance(door, AirsimDoor)
        self._sitl, self._door = sitl, door
        self._random = random.Random(seed)
        self._traffic = RpcTraffic(seed, sorted(door.method_names))
        self._clients = [self._connect() for _ in range(_N_CLIENTS)]
        self.n_sent = self.n_ticks = 0

    def tick(self) -> None:
        """Fire for 20 ms of simulated time, and ask as an honest client once a second.

        Raises:
            SilentError: If that gets no answer.
        """
        for _ in range(_A_TICK):
            self._fire(self._random.randrange(_N_CLIENTS))
        self._pass_time()
        self.n_ticks += 1
        if self.n_ticks % _CHECK_EVERY == 0:
            self._require_life()

    def _fire(self, number: int) -> None:
        client = self._clients[number]
        try:
            client.send(self._traffic.message())
            self.n_sent += 1
            if self._random.random() < 0.9:
                client.recv(_READ_BYTES)  # Others read nothing.
        except BlockingIOError:
            return
        except OSError:
            client.close()
            self._clients[number] = self._connect()
            return
        if self._random.random() < 0.02:
            client.close()
            self._clients[number] = self._connect()

    def _pass_time(self) -> None:
        if self._door.may_step(0.0):
            self._sitl.bench.simulator.step()

    def _require_life(self) -> None:
        with self._connect() as honest:
            for number, call in enumerate(([0, 1, "simPause", [False]], [0, 2, "ping", []])):
                honest.send(msgspec.msgpack.encode(call))
                expected = msgspec.msgpack.encode([1, number + 1, None, True if number else None])
                for _ in range(2000):
                    self._pass_time()
                    try:
                        if honest.recv(_READ_BYTES) == expected:
                            break
                    except BlockingIOError:
                        continue
                else:
                    raise SilentError(f"after {self.n_sent} messages")

    def _connect(self) -> socket.socket:
        client = socket.create_connection(("127.0.0.1", self._door.port))
        client.setblocking(False)
        return client

    def close(self) -> None:
        """Disconnect all."""
        for client in self._clients:
            client.close()


def besiege(n_messages: int, seed: int) -> dict[str, Any]:
    """Row of an attack with so many messages.

    Raises:
        SilentError: If an honest client is no longer answered.
    """
    bench = TestbenchCfg(speed="max", seed=seed, vehicle="iris")
    begun_s, warm_bytes = time.process_time(), None
    with Sitl(
        SitlCfg(scene="field", bench=bench, airsim=True, airsim_port=0), has_network=False
    ) as sitl:
        siege = Siege(sitl, seed)
        while siege.n_sent < n_messages:
            siege.tick()
            if warm_bytes is None and siege.n_sent > n_messages // 5:
                warm_bytes = psutil.Process().memory_info().rss
        siege.close()
        door = sitl.bench.simulator.interlude
        assert isinstance(door, AirsimDoor)
        growth = psutil.Process().memory_info().rss - (warm_bytes or 0)
        return {
            "seed": seed,
            "n_messages": siege.n_sent,
            "n_answered": door.n_answered,
            "n_faults": door.n_faults,
            "simulated_s": 1e-6 * sitl.bench.plant.time_us,
            "growth_mb": round(growth / 1e6, 1),
            "cpu_s": round(time.process_time() - begun_s, 1),
        }


def main(args: list[str] | None = None) -> int:
    """Attack; the exit status is 1 if a limit is broken."""
    parser = argparse.ArgumentParser(description="Hostile MessagePack-RPC against --airsim.")
    parser.add_argument("--messages", type=int, default=1_000_000)
    parser.add_argument("--seed", type=int, default=0)
    asked = parser.parse_args(args)
    row = besiege(asked.messages, asked.seed)
    print(json.dumps(row))
    return 1 if row["n_faults"] or row["growth_mb"] > MOST_GROWTH_MB else 0


if __name__ == "__main__":
    sys.exit(main())
