import socket
import urllib.request
from urllib.parse import parse_qs, urlsplit

import numpy as np
import psutil
import pytest

from scenarios.recording import Recorder, RunInfo
from scenarios.recording.summary import summarise
from scenarios.recording.viewer import Viewer, ViewerError, free_port, has_display
from tests import instances


def _listeners():
    """Addresses that this process and its children listen on, and their processes."""
    own = psutil.Process()
    return {
        (connection.laddr.ip, connection.laddr.port)
        for process in (own, *own.children(recursive=True))
        for connection in process.net_connections(kind="tcp")
        if connection.status == psutil.CONN_LISTEN
    }


@pytest.fixture
def listeners_before():
    return _listeners()


def test_page_and_data_are_on_loopback_only_and_gone_afterwards(flight, listeners_before):
    with Viewer("web", flight.path) as viewer:
        opened = _listeners() - listeners_before
        assert len(opened) == 3  # the page, what it is passed on from, the data
        assert {ip for ip, _ in opened} == {"127.0.0.1"}
        assert viewer.url is not None
        assert urlsplit(viewer.url).port in {port for _, port in opened}
    assert _listeners() <= listeners_before


def test_page_may_reach_this_machine_only(flight):
    with Viewer("web", flight.path) as viewer:
        with urllib.request.urlopen(viewer.url) as response:
            page = response.read()
            policy = response.headers["Content-Security-Policy"]
        assert b"re_viewer.js" in page
        data_url = parse_qs(urlsplit(viewer.url).query)["url"][0]
        data_port = urlsplit(data_url.removeprefix("rerun+")).port
        (connect,) = [part for part in policy.split("; ") if part.startswith("connect-src")]
        assert connect.split()[-1] == f"http://127.0.0.1:{data_port}"
        for other in ("fonts.googleapis.com", "rerun.io", "github.com", "*"):
            assert other not in policy


def test_live_recording_is_served_on_loopback_and_written_too(flight, tmp_path, listeners_before):
    path = tmp_path / "live.rrd"
    recorder = Recorder(
        path,
        scene=flight.scene,
        primitives=flight.primitives,
        airframe=flight.airframe,
        info=RunInfo(scene="42", vehicle="iris", seed=1),
        serve_port=free_port(0),
    )
    assert recorder.url is not None
    with recorder, Viewer("web", recorder.url) as viewer:
        opened = _listeners() - listeners_before
        assert {ip for ip, _ in opened} == {"127.0.0.1"}
        assert viewer.url is not None
        recorder.first.plans.log(40_000, np.array([(0.0, 0.0, 0.0), (1.0, 1.0, 1.0)]), 1.0)
    assert summarise(path).entities == {"/world/trajectory/planned": 1}
    assert summarise(path).is_complete
    assert _listeners() <= listeners_before


def test_window_without_display_is_refused(flight, monkeypatch):
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    if has_display():
        pytest.skip("windows need no DISPLAY on this system")
    with pytest.raises(ViewerError, match="needs a display"):
        Viewer("native", flight.path)


def test_viewer_that_cannot_start_says_why(tmp_path, listeners_before):
    with pytest.raises(ViewerError, match="did not start"):
        Viewer("web", tmp_path / "missing.rrd")
    assert _listeners() <= listeners_before


def test_free_port_prefers_the_one_asked_for_and_avoids_one_in_use():
    port = instances.free_port(socket.SOCK_STREAM)
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", port))
        taken.listen()
        assert free_port(port) != port
    assert free_port(port) == port
