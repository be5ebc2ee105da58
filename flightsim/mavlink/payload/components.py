"""Camera and gimbal as components of the vehicle: routing of messages, and orders of missions."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

from flightsim.autopilot.events import Severity
from flightsim.autopilot.mission_item import MissionItem
from flightsim.autopilot.results import CommandResult
from flightsim.mavlink.channel import Channel
from flightsim.mavlink.commands import Executor, Order
from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.faults import Faults
from flightsim.mavlink.mission_items import scale_of
from flightsim.mavlink.parsing import Message
from flightsim.mavlink.payload.camera_commands import CameraCommands
from flightsim.mavlink.payload.camera_messages import CameraMessages
from flightsim.mavlink.payload.component import Component
from flightsim.mavlink.payload.gimbal_commands import GimbalCommands
from flightsim.mavlink.payload.gimbal_messages import DEVICE_ID, Control, GimbalMessages
from flightsim.mavlink.payload.mount import Mount
from flightsim.mavlink.service import Handler, Partners
from flightsim.mavlink.statustext import StatustextSender
from flightsim.mavlink.telemetry import Producer
from flightsim.mavlink.view import VehicleView
from flightsim.payload import Payload
from flightsim.payload.photograph import Photograph

_HEARTBEAT_US = 1_000_000
_CAMERA, _GIMBAL = mav.MAV_COMP_ID_CAMERA, mav.MAV_COMP_ID_GIMBAL


class PayloadComponents:
    """The camera, component 100, and the gimbal, component 154.

    Attributes:
        executors: Their commands, for clients that address the autopilot.
        handlers: Their messages, for clients that address the autopilot.
        producers: Reports of the autopilot itself on the gimbal, for older clients.
    """

    def __init__(
        self,
        payload: Payload,
        view: VehicleView,
        everybody: Partners,
        statustext: StatustextSender,
        faults: Faults,
        autopilot_address: tuple[int, int],
    ) -> None:
        """Put a payload on the wire.

        Args:
            payload: The payload, updated here.
            view: State of the vehicle.
            everybody: All partners of the vehicle.
            statustext: Texts for people.
            faults: Guards work for clients.
            autopilot_address: System and component id of the autopilot that flies missions.
        """
        self._payload = payload
        self._statustext = statustext
        self._address = autopilot_address
        self._control = Control()
        gimbal = GimbalMessages(view, payload.gimbal, self._control)
        mount = Mount(view, payload.gimbal, self._control, statustext)
        turning = GimbalCommands(
            view,
            payload.gimbal,
            self._control,
            mount=mount,
            own_address=autopilot_address,
            # Called later, when the component below exists.
            report_status=lambda: self._gimbal.broadcast("GIMBAL_MANAGER_STATUS", gimbal.status()),
        )
        self._camera_messages = CameraMessages(view, payload, DEVICE_ID)
        component = partial(
            Component, view=view, everybody=everybody, statustext=statustext, faults=faults
        )
        producers = self._camera_messages.producers
        self._camera = component(_CAMERA, mav.MAV_TYPE_CAMERA, producers=producers, handlers={})
        handlers: Mapping[str, Handler] = {**turning.handlers, **mount.handlers}
        self._gimbal = component(
            _GIMBAL, mav.MAV_TYPE_GIMBAL, producers=gimbal.producers, handlers=handlers
        )
        taking = CameraCommands(payload, self._camera, self._camera_messages, statustext)
        self._orders = {**taking.orders, **turning.orders}
        request = {mav.MAV_CMD_REQUEST_MESSAGE: taking.request_message}
        self._camera.execute({**taking.orders, **taking.requests, **request})
        self._gimbal.execute(turning.orders)
        self.executors: Mapping[int, Executor] = {**self._orders, **taking.requests}
        self.handlers: Mapping[str, Handler] = {**handlers, **taking.handlers}
        self.producers: Mapping[str, Producer] = mount.producers
        self._components = {_CAMERA: self._camera, _GIMBAL: self._gimbal}
        payload.camera.listeners.append(self._report_photograph)

    def handle(self, component_id: int, channel: Channel, message: Message) -> str | None:
        """Handle a message that is addressed to one of the components; ignore any other.

        Returns:
            The reason why a message to one of them changes nothing, if it does not.
        """
        component = self._components.get(component_id)
        return None if component is None else component.handle(channel, message)

    def perform(self, item: MissionItem) -> None:
        """Carry out a mission item's order; one for equipment that is not aboard is skipped."""
        execute = self._orders.get(item.command)
        if execute is None:
            return
        reply = execute(
            Order(
                item.command,
                item.frame,
                *(item.param1, item.param2, item.param3, item.param4),
                *(item.x, item.y, item.z),
                # The autopilot as sender: its mission items act whoever controls the gimbal.
                self._address,
                item.x * scale_of(item.frame),
            )
        )
        if reply.result is not CommandResult.ACCEPTED:
            text = f"Mission item {item.command} {reply.result.value}: {reply.reason}"
            self._statustext.broadcast(Severity.WARNING, text)

    def work(self) -> None:
        """Let the payload work for a tick, and introduce the components once a second."""
        self._payload.update()
        if self._payload.now_us() % _HEARTBEAT_US == 0:
            for component in self._components.values():
                component.introduce()

    def update(self) -> None:
        """Send the due messages of this tick to those who have addressed a component."""
        for component in self._components.values():
            component.telemetry.update()

    def forget(self, channel: Channel) -> None:
        """Drop a partner that left."""
        for component in self._components.values():
            component.forget(channel)

    def _report_photograph(self, photograph: Photograph) -> None:
        self._camera.broadcast("CAMERA_IMAGE_CAPTURED", self._camera_messages.captured(photograph))
