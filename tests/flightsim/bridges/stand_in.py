"""A stand-in for ArduPilot that speaks its side of the JSON protocol, as a class and a program.

It is for tests alone: it flies nothing, but asks for steps with the pulses that it is told.
"""

import json
import os
import signal
import socket
import struct
import sys
import time

REQUEST = struct.Struct("<HHI16H")
MAGIC = 18458


class StandIn:
    """One end of the protocol; counts the states that it has taken."""

    def __init__(self, port):
        self._physics = ("127.0.0.1", port)
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.settimeout(20.0)
        self.count = 0

    def ask(self, pulses=(1000,) * 4):
        """Ask for a step, with these pulses for the motors 1 to 4."""
        widths = (*pulses, *(0,) * 12)
        self.send(REQUEST.pack(MAGIC, 500, self.count, *widths))

    def send(self, data):
        self._socket.sendto(data, self._physics)

    def take(self):
        """Take the state of the step asked for."""
        data = self._socket.recv(4096)
        assert data[:1] == data[-1:] == b"\n"
        self.count += 1
        return json.loads(data)

    def is_quiet(self):
        """Whether nothing has come."""
        self._socket.settimeout(0.05)
        try:
            self._socket.recv(4096)
        except TimeoutError:
            return True
        finally:
            self._socket.settimeout(20.0)
        return False

    def close(self):
        self._socket.close()


def main(fate):
    """Behave as the binary does, with its options; `fate` says what becomes of it after a while."""
    stack = StandIn(9002 + 10 * int(sys.argv[sys.argv.index("-I") + 1]))
    for _ in range(100):
        stack.ask((1100,) * 4)
        stack.take()
    sys.stdout.write("\nlast words\n")
    sys.stdout.flush()
    if fate == "exits":
        sys.exit(3)
    if fate == "is killed":
        os.kill(os.getpid(), signal.SIGKILL)
    time.sleep(60.0)  # It hangs.
