"""MAVLink server of the vehicle: links, microservices and streams, polled once per tick.

Nothing that a client sends can stop the flight: work per tick is bounded for every partner,
malformed input is ignored, and an error in answering one costs that partner's message alone.
"""

from __future__ import annotations

import contextlib
import selectors
from collections.abc import Sequence

from autonomy.types import Vector3
from flightsim.autopilot.autopilot import Autopilot
from flightsim.autopilot.events import MissionItemReached, Severity
from flightsim.frames import LocalFrame
from flightsim.mavlink.absent import AbsentService
from flightsim.mavlink.channel import Channel
from flightsim.mavlink.commands import CommandService
from flightsim.mavlink.dialect import LAYOUTS
from flightsim.mavlink.faults import Faults
from flightsim.mavlink.files import FileService
from flightsim.mavlink.flight_commands import FlightCommands
from flightsim.mavlink.ground_stations import GroundStationService
from flightsim.mavlink.links import Link
from flightsim.mavlink.manual_control import ManualControlService
from flightsim.mavlink.message_commands import MessageCommands
from flightsim.mavlink.mission import FENCE, MISSION, RALLY, MissionService
from flightsim.mavlink.offboard import OffboardService
from flightsim.mavlink.parameters import ParameterService
from flightsim.mavlink.parsing import Message
from flightsim.mavlink.personality import Personality
from flightsim.mavlink.px4 import PX4
from flightsim.mavlink.service import Handler, Partners, Service, StatefulService
from flightsim.mavlink.statustext import StatustextSender
from flightsim.mavlink.telemetry import TelemetryService
from flightsim.mavlink.telemetry_motion import MotionTelemetry
from flightsim.mavlink.telemetry_sensors import SensorTelemetry
from flightsim.mavlink.telemetry_status import StatusTelemetry
from flightsim.mavlink.timesync import TimesyncService
from flightsim.mavlink.view import VehicleView
from flightsim.plant import Plant

AUTOPILOT_COMPONENT = 1


class MavlinkServer:
    """Serves one vehicle on several links."""

    def __init__(
        self,
        autopilot: Autopilot,
        plant: Plant,
        frame: LocalFrame,
        links: Sequence[Link],
        *,
        system_id: int = 1,
        personality: Personality = PX4,
        local_origin_enu_m: Vector3 | None = None,
    ) -> None:
        """Open the links.

        Args:
            autopilot: Autopilot to control and report on.
            plant: Source of measurements.
            frame: Local frame of the scene.
            links: Links for clients; opened here, closed by `close`.
            system_id: MAVLink system id, 1 to 255.
            personality: Flight stack to imitate.
            local_origin_enu_m: Origin of MAVLink's local frame; by default the vehicle's position.

        Raises:
            LinkError: If a link cannot be opened; the others are closed again.
        """
        self.system_id = system_id
        self._autopilot = autopilot
        self._links = tuple(links)
        self._partners = Partners()
        self._identified: set[Channel] = set()
        self._selector = selectors.DefaultSelector()
        origin = local_origin_enu_m or plant.truth.position_enu_m
        self._view = VehicleView(plant, autopilot, frame, origin)
        self._build_services(personality)
        self._open_links()

    def _build_services(self, personality: Personality) -> None:
        autopilot, view, partners = self._autopilot, self._view, self._partners
        self.statustext = StatustextSender(partners)
        self.faults = Faults(lambda line: self.statustext.say(Severity.ERROR, line))
        rotors = view.plant.world.airframe.quadrotor.rotors
        max_rotor_speed = max(rotor.max_speed_radps for rotor in rotors)
        self.telemetry = TelemetryService(
            {
                **StatusTelemetry(view, personality, self.system_id).producers,
                **MotionTelemetry(view).producers,
                **SensorTelemetry(view, max_rotor_speed_radps=max_rotor_speed).producers,
            },
            partners,
            lambda: view.plant.time_us,
        )
        stores = {MISSION: autopilot.mission, FENCE: autopilot.fence, RALLY: autopilot.rally}
        self._missions = MissionService(stores, partners, self.statustext)
        self._flight_commands = FlightCommands(view, personality)
        message_commands = MessageCommands(self.telemetry, personality)
        parameters = ParameterService(autopilot.parameters, partners, self.statustext)
        executors = {**self._flight_commands.executors, **message_commands.executors}
        services: Sequence[Service] = (
            CommandService(executors, self.statustext),
            OffboardService(view),
            ManualControlService(autopilot, self.system_id),
            TimesyncService(lambda: view.plant.time_us),
            FileService(),
            AbsentService(self.statustext),
        )
        self._stateful: Sequence[StatefulService] = (
            GroundStationService(autopilot),
            self._missions,
            parameters,
            self.telemetry,
        )
        self._handlers: dict[int, Handler] = {
            LAYOUTS[name].message_id: handler
            for service in (*services, *self._stateful)
            for name, handler in service.handlers.items()
        }
        self._handlers |= {
            LAYOUTS["SET_MODE"].message_id: lambda _, m: self._flight_commands.on_set_mode(m),
            LAYOUTS["MISSION_SET_CURRENT"].message_id: self._on_set_current,
            LAYOUTS["SET_GPS_GLOBAL_ORIGIN"].message_id: self._on_set_origin,
        }

    def _open_links(self) -> None:
        with contextlib.ExitStack() as opened:
            for link in self._links:
                link.open(self._selector, lambda: self._view.time_us)
                opened.callback(link.close)
            opened.pop_all()

    @property
    def channels(self) -> Sequence[Channel]:
        """All present partners."""
        return self._partners.channels

    def update(self) -> None:
        """Read, answer, stream and send; call once every 20 ms of simulated time."""
        faults = self.faults
        for key, _ in self._selector.select(0):
            with faults:
                key.data()
        self._view.refresh()
        self._meet_partners()
        for channel in self._partners.channels:
            for message in channel.take_messages():
                with faults:
                    self._dispatch(channel, message)
        self._tell_events()
        self.statustext.end_tick()
        for service in self._stateful:
            for channel in self._partners.channels:
                with faults:
                    service.update(channel)
                if faults.has_failed:
                    service.forget(channel)  # Else it would fail again at every tick.
        for channel in self._partners.channels:
            with faults:
                channel.flush()

    def close(self) -> None:
        """Release all ports. Closing twice is fine."""
        for link in self._links:
            link.close()
        self._selector.close()

    def _meet_partners(self) -> None:
        channels = [channel for link in self._links for channel in link.channels]
        if len(channels) == len(self._identified) and self._identified.issuperset(channels):
            return
        for gone in self._identified.difference(channels):
            for service in self._stateful:
                service.forget(gone)
        for channel in channels:
            channel.system_id = self.system_id
            channel.component_id = AUTOPILOT_COMPONENT
        self._identified = set(channels)
        self._partners.channels = channels

    def _dispatch(self, channel: Channel, message: Message) -> None:
        handler = self._handlers.get(message.get_msgId())
        sender = (message.get_srcSystem(), message.get_srcComponent())
        if handler is None or sender == (self.system_id, AUTOPILOT_COMPONENT):
            return
        if getattr(message, "target_system", 0) not in {0, self.system_id}:
            return
        if getattr(message, "target_component", 0) not in {0, AUTOPILOT_COMPONENT}:
            return
        handler(channel, message)

    def _tell_events(self) -> None:
        for event in self._autopilot.pop_events():
            if isinstance(event, MissionItemReached):
                self._missions.announce_reached(event.index)
            else:
                self.statustext.say(event.severity, event.text)

    def _on_set_current(self, channel: Channel, message: Message) -> None:
        reply = self._autopilot.set_current_mission_item(message.seq)
        if reply.is_accepted:
            self.telemetry.broadcast("MISSION_CURRENT")
        else:
            self.telemetry.send_now(channel, LAYOUTS["MISSION_CURRENT"].message_id)

    def _on_set_origin(self, channel: Channel, _: Message) -> None:
        # PX4 answers with the origin that holds; here that is where the vehicle started.
        self.statustext.say(Severity.NOTICE, "The origin stays where the vehicle started")
        self.telemetry.send_now(channel, LAYOUTS["GPS_GLOBAL_ORIGIN"].message_id)
