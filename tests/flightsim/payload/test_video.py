"""The stream and the films, read back by FFmpeg's own depacketiser, demuxer and decoder."""

import math
import re
import socket
import threading
import time
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import av
import numpy as np
import pytest

from flightsim.payload.gimbal import Gimbal
from flightsim.payload.lens import Lens
from flightsim.payload.video import FRAME_US, Film, VideoError, VideoStream, encoder
from flightsim.payload.video.rtp import MAX_PAYLOAD_BYTES, Packetiser, payloads_of
from flightsim.plant import Plant, PlantCfg
from tests.instances import free_port

_PAGE = Path(__file__).parents[3] / "docs" / "camera.md"
_LEAST_PSNR_DB = 32.0
"""What a picture keeps at 2 Mbit/s; a picture of a frame before has less."""


def _psnr_db(a: np.ndarray, b: np.ndarray) -> float:
    error = np.mean((a.astype(float) - b.astype(float)) ** 2)
    return 10.0 * math.log10(255.0**2 / error)


def _sdp(folder: Path, port: int) -> Path:
    """The description of the stream that the page gives, for a port."""
    (text,) = re.findall(r"```sdp\n(.*?)```", _PAGE.read_text(encoding="utf-8"), re.DOTALL)
    path = folder / "stream.sdp"
    path.write_text(text.replace(" 5600 ", f" {port} "), encoding="utf-8")
    return path


class _Relay:
    """Passes packets on from one port to another, as a network does."""

    def __init__(self, to_port: int, lost: Callable[[bytes], bool] | None = None):
        self.packets: list[bytes] = []
        self._to = ("127.0.0.1", to_port)
        self._lost = lost
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind(("127.0.0.1", 0))
        self._socket.setblocking(False)
        self.port = self._socket.getsockname()[1]

    def pass_on(self) -> None:
        while True:
            try:
                packet = self._socket.recv(65536)
            except BlockingIOError:
                return
            self.packets.append(packet)
            if self._lost is None or not self._lost(packet):
                self._socket.sendto(packet, self._to)

    def close(self) -> None:
        self._socket.close()


def _watch(
    tmp_path: Path,
    pictures: list[np.ndarray],
    n_frames: int,
    lost: Callable[[bytes], bool] | None = None,
):
    """Stream pictures, repeated, and return what a player decodes, and the packets."""
    port = free_port(socket.SOCK_DGRAM)
    relay = _Relay(port, lost)
    height, width = pictures[0].shape[:2]
    shown = iter(range(10_000_000))
    stream = VideoStream(relay.port, (width, height), lambda: pictures[next(shown) % len(pictures)])
    seen: list[np.ndarray] = []

    def play() -> None:
        options = {
            "protocol_whitelist": "file,udp,rtp",
            "analyzeduration": "1",
            "fflags": "nobuffer",
        }
        with av.open(str(_sdp(tmp_path, port)), format="sdp", options=options, timeout=30) as video:
            for frame in video.decode(video=0):
                seen.append(frame.to_ndarray(format="rgb24"))
                if len(seen) >= n_frames:
                    return

    player = threading.Thread(target=play, daemon=True)
    player.start()
    now_us = 0
    deadline = time.monotonic() + 60.0
    while player.is_alive() and time.monotonic() < deadline:
        stream.update(now_us)
        relay.pass_on()
        now_us += FRAME_US
        time.sleep(0.01)
    stream.close()
    relay.close()
    player.join(32.0)
    return seen, relay.packets


@pytest.fixture(scope="module")
def pictures(field):
    """What the gimbal's camera sees at four yaws."""
    plant = Plant(field, PlantCfg(seed=3))
    gimbal = Gimbal()
    lens = Lens(plant, gimbal)
    seen = []
    for yaw_rad in (0.0, 0.8, 1.6, 2.4):
        gimbal.yaw_rad = yaw_rad
        gimbal.pitch_down_rad = 0.1
        plant.advance()
        seen.append(lens.render("video").rgb)
    lens.close()
    return seen


def test_a_player_sees_what_was_rendered(tmp_path, pictures):
    seen, packets = _watch(tmp_path, pictures, 12)
    assert len(seen) == 12
    best = [max(_psnr_db(frame, picture) for picture in pictures) for frame in seen]
    assert min(best) > _LEAST_PSNR_DB, best
    # One after the other: each picture is nearest to what was shown in its turn.
    order = [int(np.argmax([_psnr_db(f, p) for p in pictures])) for f in seen]
    steps = {(b - a) % len(pictures) for a, b in pairwise(order)}
    assert steps == {1}
    assert any(packet[12] & 0x1F == 28 for packet in packets), "no frame was fragmented"
    assert max(map(len, packets)) <= 12 + MAX_PAYLOAD_BYTES


def test_a_lost_fragment_is_seen(tmp_path, pictures):
    """The test above can fail: without the last fragments the pictures are torn."""

    def is_last_fragment(packet: bytes) -> bool:
        return packet[12] & 0x1F == 28 and bool(packet[13] & 0x40)

    seen, _ = _watch(tmp_path, pictures, 6, is_last_fragment)
    best = [max(_psnr_db(frame, picture) for picture in pictures) for frame in seen]
    assert not best or min(best) < _LEAST_PSNR_DB


def test_packets_are_numbered_and_the_last_of_a_frame_is_marked():
    packetiser = Packetiser(0x01020304)
    packetiser._sequence = 0xFFFF
    packets = list(packetiser.packets([b"\x67abc", b"\x65" + bytes(3000)], 0x1_0000_0007))
    assert [int.from_bytes(p[2:4], "big") for p in packets] == [0xFFFF, 0, 1, 2]
    assert [p[1] for p in packets] == [96, 96, 96, 0x80 | 96]
    assert {p[0] for p in packets} == {0x80}
    assert {p[4:12] for p in packets} == {bytes((0, 0, 0, 7, 1, 2, 3, 4))}


@pytest.mark.parametrize("size", [1, MAX_PAYLOAD_BYTES, MAX_PAYLOAD_BYTES + 1, 2797, 2798, 5000])
def test_fragments_join_to_the_unit(size):
    unit = bytes((0x65, *(i % 251 for i in range(size - 1))))
    payloads = list(payloads_of(unit))
    if size <= MAX_PAYLOAD_BYTES:
        assert payloads == [unit]
        return
    assert {p[0] for p in payloads} == {0x60 | 28}
    assert [p[1] & 0xC0 for p in payloads] == [0x80, *[0] * (len(payloads) - 2), 0x40]
    assert {p[1] & 0x1F for p in payloads} == {5}
    assert bytes((payloads[0][0] & 0xE0 | 5,)) + b"".join(p[2:] for p in payloads) == unit
    assert max(map(len, payloads)) <= MAX_PAYLOAD_BYTES


def test_a_film_can_be_played(tmp_path, pictures):
    height, width = pictures[0].shape[:2]
    path = tmp_path / "VID_0000.mp4"
    film = Film(path, (width, height))
    for picture in pictures * 2:
        film.add(picture)
    assert not path.exists()
    assert film.close() == path.stat().st_size
    assert list(tmp_path.iterdir()) == [path]
    with av.open(str(path)) as video:
        assert video.streams.video[0].average_rate == 10
        frames = [frame.to_ndarray(format="rgb24") for frame in video.decode(video=0)]
    assert len(frames) == 2 * len(pictures)
    for frame, picture in zip(frames, pictures * 2, strict=True):
        assert _psnr_db(frame, picture) > _LEAST_PSNR_DB


def test_nobody_need_listen(pictures):
    height, width = pictures[0].shape[:2]
    stream = VideoStream(free_port(socket.SOCK_DGRAM), (width, height), lambda: pictures[0])
    stream.update(0)
    stream.update(20_000)
    n_bytes = stream.n_bytes
    assert n_bytes > 0
    stream.update(FRAME_US)
    assert stream.n_bytes > n_bytes
    stream.is_running = False
    stream.update(2 * FRAME_US)
    stream.close()


def test_without_an_encoder_a_stream_says_what_to_install(monkeypatch):
    monkeypatch.setattr(encoder, "has_encoder", lambda: False)
    with pytest.raises(VideoError, match="pip install 'aeroscene\\[video\\]'"):
        VideoStream(5600, (640, 480), lambda: np.zeros((480, 640, 3), np.uint8))
