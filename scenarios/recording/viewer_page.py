"""The web viewer's page, passed on from rerun's own server with a policy that keeps it local.

rerun's page fetches fonts, looks for new versions and reports its use to servers elsewhere, and it
has no switch against that. A content security policy in the response makes the browser refuse, so
that the page reaches this machine only.

A script in the page keeps a connection open for as long as the page is open. When the connection
breaks, we know that the reader has left.
"""

from __future__ import annotations

import http.client
import threading
import time
from collections.abc import Callable
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from io import BufferedIOBase
from typing import Self

LOOPBACK = "127.0.0.1"
_UPSTREAM_TIMEOUT_S = 10.0
_PASSED_HEADERS = ("Content-Type", "Content-Encoding", "rerun-final-length")
_READER_PATH = "/reader"
_READER_SCRIPT = f"<script>new EventSource('{_READER_PATH}')</script>".encode()
_PULSE_S = 0.5
_RELOAD_S = 3.0
"""A page that is back within this time was loaded anew, not left."""


def content_policy(data_port: int) -> str:
    """Return a policy under which the page may only load from its server and stream from a port.

    Args:
        data_port: Loopback port of the recording.
    """
    return "; ".join(
        (
            "default-src 'self' data: blob:",
            "script-src 'self' 'unsafe-inline' 'unsafe-eval' 'wasm-unsafe-eval' blob:",
            "style-src 'self' 'unsafe-inline'",
            f"connect-src 'self' data: blob: http://{LOOPBACK}:{data_port}",
        )
    )


class PageServer:
    """Serves the page on a loopback port, in a thread that sleeps unless a browser asks.

    Attributes:
        port: Port of the page.
    """

    def __init__(self, port: int, upstream_port: int, data_port: int) -> None:
        """Start serving.

        Args:
            port: Loopback port to serve on; 0 lets the system choose.
            upstream_port: Loopback port of rerun's own page server.
            data_port: Loopback port that the page streams the recording from.

        Raises:
            OSError: If the port is taken.
        """
        self._readers: set[object] = set()
        self._last_left_s: float | None = None
        handler = _handler(upstream_port, content_policy(data_port), self._stay)
        self._server = ThreadingHTTPServer((LOOPBACK, port), handler)
        self.port: int = self._server.server_address[1]
        self._thread = threading.Thread(target=self._server.serve_forever, daemon=True)
        self._thread.start()

    @property
    def was_closed(self) -> bool:
        """True if the page was open in some browser, and is not open in any now."""
        left_s = self._last_left_s
        return not self._readers and left_s is not None and time.monotonic() > left_s + _RELOAD_S

    def _stay(self, page: BufferedIOBase) -> None:
        """Write to an open page until it is closed."""
        reader = object()
        self._readers.add(reader)
        try:
            while True:
                # A comment line of the event stream, which browsers ignore. Writing is the only
                # way to notice that the other end has gone.
                page.write(b": still here\n\n")
                time.sleep(_PULSE_S)
        except OSError:
            self._last_left_s = time.monotonic()
        finally:
            self._readers.discard(reader)

    def close(self) -> None:
        """Stop serving and give the port back."""
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()


def _handler(
    upstream_port: int, policy: str, stay: Callable[[BufferedIOBase], None]
) -> type[BaseHTTPRequestHandler]:
    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            path = self.path.partition("?")[0]
            if path == _READER_PATH:
                self.send_response(200)
                self.send_header("Content-Type", "text/event-stream")
                self.end_headers()
                stay(self.wfile)
                return
            upstream = http.client.HTTPConnection(
                LOOPBACK, upstream_port, timeout=_UPSTREAM_TIMEOUT_S
            )
            try:
                upstream.request("GET", path)
                response = upstream.getresponse()
                content = response.read()
            except OSError:
                self.send_error(502, "the viewer has ended")
                return
            if path == "/":
                # The length changes with it, so the header below is our own.
                content = content.replace(b"</body>", _READER_SCRIPT + b"</body>")
            self.send_response(response.status)
            for name in _PASSED_HEADERS:
                if (value := response.headers.get(name)) is not None:
                    self.send_header(name, value)
            self.send_header("Content-Length", str(len(content)))
            self.send_header("Content-Security-Policy", policy)
            self.end_headers()
            self.wfile.write(content)
            upstream.close()

        def log_message(self, format: str, *args: object) -> None:  # noqa: A002 - its base's name
            """Log no requests."""

    return Handler
