"""Commands of the camera: photographs, films, the stream, its mode, and older requests."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from flightsim.autopilot.events import Severity
from flightsim.autopilot.results import ACCEPTED, Reply, denied
from flightsim.mavlink.channel import Channel
from flightsim.mavlink.commands import Command, Executor, Order, choice, explanation
from flightsim.mavlink.dialect import LAYOUTS
from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.message_commands import DENIED, MessageCommands
from flightsim.mavlink.parsing import Message
from flightsim.mavlink.payload.camera_messages import STREAM_ID, CameraMessages
from flightsim.mavlink.payload.component import Component
from flightsim.mavlink.service import Handler
from flightsim.mavlink.statustext import StatustextSender
from flightsim.payload import Payload
from flightsim.payload.camera import CameraMode

OrderExecutor = Callable[[Order], Reply]
"""Carries out the order of a command or a mission item."""

_MODES = {mav.CAMERA_MODE_IMAGE: CameraMode.PHOTO, mav.CAMERA_MODE_VIDEO: CameraMode.VIDEO}
_FIXED = denied("zoom and focus are fixed; valid is shot = 1 (param5), a picture")
_IMAGE_CAPTURED = LAYOUTS["CAMERA_IMAGE_CAPTURED"].message_id


class CameraCommands:
    """Executes orders for the camera.

    Attributes:
        orders: Orders that clients and mission items may give.
        requests: Requests that only clients may make, because they get the answer.
        handlers: Messages of older clients, which have no answer.
    """

    def __init__(
        self,
        payload: Payload,
        component: Component,
        messages: CameraMessages,
        statustext: StatustextSender,
    ) -> None:
        self._camera = payload.camera
        self._shutter = payload.camera.shutter
        self._video = payload.video
        self._now_us = payload.now_us
        self._component = component
        self._messages = messages
        self._statustext = statustext
        self.handlers: Mapping[str, Handler] = {"DIGICAM_CONTROL": self._on_digicam_control}
        self._plain = MessageCommands(component.telemetry)
        self._last_capture: tuple[tuple[int, int], float, float, float] | None = None
        self.orders: Mapping[int, OrderExecutor] = {
            mav.MAV_CMD_IMAGE_START_CAPTURE: self._start_capture,
            mav.MAV_CMD_IMAGE_STOP_CAPTURE: self._stop_capture,
            mav.MAV_CMD_VIDEO_START_CAPTURE: lambda _: self._camera.start_film(),
            mav.MAV_CMD_VIDEO_STOP_CAPTURE: self._stop_film,
            mav.MAV_CMD_VIDEO_START_STREAMING: lambda c: self._stream(c, is_on=True),
            mav.MAV_CMD_VIDEO_STOP_STREAMING: lambda c: self._stream(c, is_on=False),
            mav.MAV_CMD_SET_CAMERA_MODE: self._set_mode,
            mav.MAV_CMD_DO_DIGICAM_CONTROL: self._digicam_control,
            mav.MAV_CMD_DO_SET_CAM_TRIGG_DIST: self._trigger_by_way,
            mav.MAV_CMD_DO_SET_CAM_TRIGG_INTERVAL: self._trigger_by_time,
            mav.MAV_CMD_DO_TRIGGER_CONTROL: self._control_trigger,
        }
        self.requests: Mapping[int, Executor] = {
            mav.MAV_CMD_REQUEST_CAMERA_INFORMATION: self._sends("CAMERA_INFORMATION"),
            mav.MAV_CMD_REQUEST_CAMERA_SETTINGS: self._sends("CAMERA_SETTINGS"),
            mav.MAV_CMD_REQUEST_STORAGE_INFORMATION: self._sends("STORAGE_INFORMATION"),
            mav.MAV_CMD_REQUEST_CAMERA_CAPTURE_STATUS: self._sends("CAMERA_CAPTURE_STATUS"),
            mav.MAV_CMD_REQUEST_CAMERA_IMAGE_CAPTURE: lambda c: self._send_captured(c, c.param1),
            mav.MAV_CMD_REQUEST_VIDEO_STREAM_INFORMATION: self._sends("VIDEO_STREAM_INFORMATION"),
            mav.MAV_CMD_REQUEST_VIDEO_STREAM_STATUS: self._sends("VIDEO_STREAM_STATUS"),
        }

    def request_message(self, c: Command) -> Reply:
        """Send the message of parameter 1; of a photograph, the one that parameter 2 names."""
        if choice(c.param1) == _IMAGE_CAPTURED:
            return self._send_captured(c, c.param2)
        return self._plain.request(c)

    # --- photographs ---

    def _start_capture(self, c: Order) -> Reply:
        order = (c.sender, c.param2, c.param3, c.param4)
        # param4 is a sequence number; clients that count their orders never repeat one on purpose.
        is_numbered = c.param4 > 0.0
        if order == self._last_capture and (is_numbered or self._shutter.is_in_series):
            return ACCEPTED  # the same again, because its acknowledgement was lost
        reply = self._shoot(c)
        if reply.is_accepted:
            self._last_capture = order
        return reply

    def _shoot(self, c: Order) -> Reply:
        n_pictures, interval_s = choice(c.param3, default=1), c.param2
        if n_pictures is None:
            return denied(f"{c.param3:g} pictures; valid are whole numbers")
        return self._shutter.shoot(
            self._now_us(), n_pictures, 0.0 if math.isnan(interval_s) else interval_s
        )

    def _stop_capture(self, _: Order) -> Reply:
        self._shutter.stop()
        return ACCEPTED

    def _digicam_control(self, c: Order) -> Reply:
        if choice(c.param5) == 1:
            return self._shutter.shoot(self._now_us())
        return _FIXED

    def _on_digicam_control(self, _: Channel, m: Message) -> None:
        reply = self._shutter.shoot(self._now_us()) if m.shot == 1 else _FIXED
        if reply.reason:
            self._statustext.broadcast(Severity.WARNING, explanation("DIGICAM_CONTROL", reply))

    def _trigger_by_way(self, c: Order) -> Reply:
        return self._shutter.each(c.param1, is_at_once=c.param3 == 1.0)

    def _trigger_by_time(self, c: Order) -> Reply:
        # A new interval replaces the running one, and 0 ends it.
        self._shutter.stop()
        if not c.param1 > 0.0:
            return ACCEPTED
        return self._shutter.shoot(self._now_us(), 0, 1e-3 * c.param1)

    def _control_trigger(self, c: Order) -> Reply:
        if not {c.param1, c.param3} & {0.0, 1.0}:
            # Both parameters: param1 turns the trigger on and off, param3 pauses it.
            return denied(f"param1 = {c.param1:g}, param3 = {c.param3:g}; valid are 0 and 1")
        if c.param1 in {0.0, 1.0}:
            self._shutter.is_paused = c.param1 == 0.0
        if c.param3 in {0.0, 1.0} and c.param1 != 0.0:
            self._shutter.is_paused = c.param3 == 1.0
        return ACCEPTED

    def _set_mode(self, c: Order) -> Reply:
        number = choice(c.param2)
        mode = None if number is None else _MODES.get(number)
        if mode is None:
            return denied(f"camera mode {c.param2:g}; valid are 0 (photo) and 1 (video)")
        self._camera.mode = mode
        return ACCEPTED

    # --- moving pictures ---

    def _stop_film(self, _: Order) -> Reply:
        self._camera.stop_film()
        return ACCEPTED

    def _stream(self, c: Order, *, is_on: bool) -> Reply:
        if self._video is None:
            return denied("there is no stream; aeroscene sitl --video makes one")
        # 0 means all streams, and there is one.
        if choice(c.param1, default=0) not in {0, STREAM_ID}:
            return denied(f"stream {c.param1:g}; valid is {STREAM_ID}")
        self._video.is_running = is_on
        return ACCEPTED

    # --- requests ---

    def _sends(self, name: str) -> Executor:
        message_id = LAYOUTS[name].message_id
        return lambda c: self._plain.send_once(self._component.channel_for(c.channel), message_id)

    def _send_captured(self, c: Command, number: float) -> Reply:
        index = choice(number)
        photograph = None if index is None else self._camera.photograph(index)
        if photograph is None:
            return DENIED
        payload = self._messages.captured(photograph)
        self._component.channel_for(c.channel).send(LAYOUTS["CAMERA_IMAGE_CAPTURED"], payload)
        return ACCEPTED
