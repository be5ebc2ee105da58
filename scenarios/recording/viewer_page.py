"""The web viewer's page, passed on from rerun's own server with a policy that keeps it local.

rerun's page fetches fonts, looks for new versions and reports its use to servers elsewhere, and
has no switch against it. A content security policy in the response makes the browser refuse: the
page reaches this machine only.
"""

from __future__ import annotations

import http.client
import shutil
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Self

LOOPBACK = "127.0.0.1"
_UPSTREAM_TIMEOUT_S = 10.0
_PASSED_HEADERS = ("Content-Type", "Content-Encoding", "Content-Length", "rerun-final-length")


def content_policy(data_port: int) -> str:
    """A policy under which the page may load from its own server and stream from one port."""
    return "; ".join(
        (
            "default-src 'self' data: blob:",
            "script-src 'self' 'unsafe-inline' 'unsafe-eval' 'wasm-unsafe-eval' blob:",
            "style-src 'self' 'unsafe-inline'",
            f"connect-src 'self' data: blob: http://{LOOPBACK}:{data_port}",
        )
    )


class PageServer:
    """Serves the page on a loopback port, in a thread that waits unless a browser asks.

    Attributes:
        port: Where it serves.
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
        handler = _handler(upstream_port, content_policy(data_port))
        self._server = ThreadingHTTPServer((LOOPBACK, port), handler)
        self.port: int = self._server.server_address[1]
        self._thread = threading.Thread(target=self._server.serve_forever, daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Stop serving and give the port back."""
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()


def _handler(upstream_port: int, policy: str) -> type[BaseHTTPRequestHandler]:
    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            upstream = http.client.HTTPConnection(
                LOOPBACK, upstream_port, timeout=_UPSTREAM_TIMEOUT_S
            )
            try:
                upstream.request("GET", self.path.partition("?")[0])
                response = upstream.getresponse()
            except OSError:
                self.send_error(502, "the viewer has ended")
                return
            self.send_response(response.status)
            for name in _PASSED_HEADERS:
                if (value := response.headers.get(name)) is not None:
                    self.send_header(name, value)
            self.send_header("Content-Security-Policy", policy)
            self.end_headers()
            shutil.copyfileobj(response, self.wfile)
            upstream.close()

        def log_message(self, format: str, *args: object) -> None:  # noqa: A002 - its base's name
            """Say nothing about every request."""

    return Handler
