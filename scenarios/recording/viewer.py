"""rerun's viewer, live or on a file, as a child process that listens on loopback only.

The child has a process group of its own, so that it can be ended with everything that it started.
A page goes through `viewer_page.PageServer`, because rerun's own page would call other machines.
"""

from __future__ import annotations

import logging
import os
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Literal, Self
from urllib.parse import quote

from scenarios.recording.program import quiet_environment, rerun_program
from scenarios.recording.viewer_page import LOOPBACK, PageServer

_log = logging.getLogger(__name__)

ViewerKind = Literal["web", "native"]

PAGE_PORT = 9090
"""Preferred port of the web page; another one is used if it is taken."""
DATA_PORT = 9876
"""Preferred port of the recording for viewers; another one is used if it is taken."""
_START_TIMEOUT_S = 20.0
_END_TIMEOUT_S = 3.0
_LOOK_S = 0.2


class ViewerError(RuntimeError):
    """The viewer cannot be opened here."""


class Viewer:
    """An open viewer; closing it ends its processes.

    Attributes:
        url: The page to open in a browser; None for the native viewer.
    """

    def __init__(self, kind: ViewerKind, source: str | Path) -> None:
        """Open a viewer.

        Args:
            kind: "web" serves a page on loopback, "native" opens a window.
            source: A live recording's URL, or an .rrd file.

        Raises:
            ViewerError: If there is no display for a window, or the viewer does not start.
        """
        self.url: str | None = None
        self._page: PageServer | None = None
        with ExitStack() as stack:
            if kind == "native":
                self._open_window(stack, source)
            else:
                self._serve_page(stack, source)
            # Only now: a start that fails halfway has closed what it opened.
            self._stack = stack.pop_all()

    def _open_window(self, stack: ExitStack, source: str | Path) -> None:
        if not has_display():
            raise ViewerError("viewer 'native' needs a display and there is none; valid: web")
        # Not the preferred port itself, on which the live recording may be served.
        port = free_port(DATA_PORT + 1)
        connect = ["--connect", source] if isinstance(source, str) else [str(source)]
        self._process = _RerunProcess(["--bind", LOOPBACK, "--port", str(port), *connect])
        stack.callback(self._process.close)
        self._process.wait_for_port(port)

    def _serve_page(self, stack: ExitStack, source: str | Path) -> None:
        # rerun serves its page on a port that nobody is told of; ours passes it on.
        upstream_port = free_port(0)
        arguments = ["--serve-web", "--bind", LOOPBACK, "--web-viewer-port", str(upstream_port)]
        if isinstance(source, str):
            data_url = source
            data_port = int(source.rpartition(":")[2].partition("/")[0])
        else:
            data_port = free_port(DATA_PORT)
            data_url = f"rerun+http://{LOOPBACK}:{data_port}/proxy"
            arguments += ["--port", str(data_port)]
        self._process = _RerunProcess([*arguments, str(source)])
        stack.callback(self._process.close)
        self._process.wait_for_port(upstream_port)
        self._page = page = PageServer(free_port(PAGE_PORT), upstream_port, data_port)
        stack.callback(page.close)
        self.url = f"http://{LOOPBACK}:{page.port}/?url={quote(data_url, safe='')}"
        _log.info("watch at %s", self.url)

    def wait(self) -> None:
        """Block until the user closes the window, or the page after having opened it."""
        while not self._process.has_ended(_LOOK_S) and not (self._page and self._page.was_closed):
            pass

    def close(self) -> None:
        """End the viewer and its processes."""
        self._stack.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()


class _RerunProcess:
    """The `rerun` program in a process group of its own."""

    def __init__(self, arguments: Sequence[str]) -> None:
        # A file, because a pipe that nobody reads would fill up and block the viewer.
        self._output = tempfile.TemporaryFile()  # noqa: SIM115 - closed with the process
        self._process = subprocess.Popen(  # noqa: S603 - arguments are ours
            [str(rerun_program()), *arguments],
            stdin=subprocess.DEVNULL,
            stdout=self._output,
            stderr=self._output,
            start_new_session=True,
            env=quiet_environment(),
        )

    def wait_for_port(self, port: int) -> None:
        """Return when the viewer listens.

        Args:
            port: Port on loopback that it was asked to use.

        Raises:
            ViewerError: With the viewer's last words, if it ends instead.
        """
        deadline_s = time.monotonic() + _START_TIMEOUT_S
        while not _is_listening(port):
            if self._process.poll() is not None or time.monotonic() > deadline_s:
                raise ViewerError(f"viewer did not start: {self._last_words()}")
            time.sleep(0.05)

    def has_ended(self, timeout_s: float) -> bool:
        """Wait up to a time for the process to end, and return true if it did."""
        try:
            self._process.wait(timeout_s)
        except subprocess.TimeoutExpired:
            return False
        return True

    def close(self) -> None:
        """End the whole process group, first by SIGTERM and then by SIGKILL."""
        for ending in (signal.SIGTERM, signal.SIGKILL):
            try:
                os.killpg(self._process.pid, ending)
            # macOS reports a missing permission for a group whose processes have all ended.
            except (ProcessLookupError, PermissionError):
                break
            try:
                self._process.wait(_END_TIMEOUT_S)
            except subprocess.TimeoutExpired:
                continue
        self._process.wait()
        self._output.close()

    def _last_words(self) -> str:
        self._output.seek(0)
        lines = self._output.read().decode(errors="replace").strip().splitlines()
        return lines[-1] if lines else "it said nothing"


def has_display() -> bool:
    """Return true if a window can be opened: on Linux, if X11 or Wayland has a display."""
    if sys.platform != "linux":
        return True
    return any(os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY"))


def free_port(preferred: int) -> int:
    """Return the preferred TCP port on loopback if it is free, else another one.

    Args:
        preferred: Port to try first; 0 lets the system choose.

    Raises:
        ViewerError: If no port is free.
    """
    for port in (preferred, 0):
        with socket.socket() as probe:
            # A port that was just released may linger harmlessly.
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            try:
                probe.bind((LOOPBACK, port))
            except OSError:
                continue
            return probe.getsockname()[1]
    raise ViewerError(f"no free TCP port on {LOOPBACK}")


def _is_listening(port: int) -> bool:
    with socket.socket() as probe:
        probe.settimeout(0.5)
        return probe.connect_ex((LOOPBACK, port)) == 0
