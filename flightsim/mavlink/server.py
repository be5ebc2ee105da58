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
from flightsim.mavlink.failure_commands import FailureCommands
from flightsim.mavlink.faults import Faults
from flightsim.mavlink.files import FileService
from flightsim.mavlink.flight_commands import FlightCommands
from flightsim.mavlink.follow_target import FollowTargetService
from flightsim.mavlink.ground_stations import GroundStationService
from flightsim.mavlink.guided import GuidedInput
from flightsim.mavlink.links import Link
from flightsim.mavlink.lockstep import Lockstep
from flightsim.mavlink.logs import FlightRecorder, LogService
from flightsim.mavlink.manual_control import ManualControlService
from flightsim.mavlink.message_commands import MessageCommands
from flightsim.mavlink.mission import FENCE, MISSION, RALLY, MissionService
from flightsim.mavlink.mission_with_home import MissionWithHome
from flightsim.mavlink.mode_report import ModeReport
from flightsim.mavlink.offboard import OffboardService
from flightsim.mavlink.old_requests import OldRequestService
from flightsim.mavlink.parameter_names import AliasedParameters
from flightsim.mavlink.parameters import ParameterService
from flightsim.mavlink.parsing import Message
from flightsim.mavlink.personalities import PX4, Personality
from flightsim.mavlink.service import Handler, Partners, Service, StatefulService
from flightsim.mavlink.shell import ShellService
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
        has_lockstep: bool = False,
        ticks_per_datagram: int = 1,
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
            has_lockstep: Whether a client may keep the time; `wait_for_tick` then waits for it.
            ticks_per_datagram: Number of ticks whose streams share a datagram; answers never wait.

        Raises:
            LinkError: If a link cannot be opened; the others are closed again.
        """
        self.system_id = system_id
        self._autopilot = autopilot
        self._links = tuple(links)
        self._partners = Partners()
        self._identified: set[Channel] = set()
        self._selector = selectors.DefaultSelector()
        self._ticks_per_datagram = ticks_per_datagram
        self._n_ticks = 0
        origin = local_origin_enu_m or plant.truth.position_enu_m
        self._view = VehicleView(plant, autopilot, frame, origin)
        self.lockstep = Lockstep() if has_lockstep else None
        self.statustext = StatustextSender(self._partners)
        self.faults = Faults(lambda line: self.statustext.say(Severity.ERROR, line))
        self._build_services(personality)
        self._open_links()

    def _build_telemetry(self, personality: Personality, modes: ModeReport) -> TelemetryService:
        view = self._view
        rotors = view.plant.world.airframe.quadrotor.rotors
        max_rotor_speed = max(rotor.max_speed_radps for rotor in rotors)
        return TelemetryService(
            {
                **StatusTelemetry(view, personality, modes, self.system_id).producers,
                **MotionTelemetry(view).producers,
                **SensorTelemetry(view, max_rotor_speed_radps=max_rotor_speed).producers,
                **personality.extra_telemetry(view),
            },
            self._partners,
            lambda: view.plant.time_us,
        )

    def _build_services(self, personality: Personality) -> None:
        autopilot, view, partners = self._autopilot, self._view, self._partners
        statustext, modes = self.statustext, ModeReport(personality, autopilot)
        self.telemetry = self._build_telemetry(personality, modes)
        guided = GuidedInput(view, modes) if personality.has_guided_mode else None
        self._recorder = FlightRecorder(view, statustext)
        self._missions = MissionService(
            {
                MISSION: MissionWithHome(autopilot)
                if personality.n_home_items
                else autopilot.mission,
                FENCE: autopilot.fence,
                RALLY: autopilot.rally,
            },
            partners,
            statustext,
            guided.accept_item if guided else None,
            requests_int=personality.requests_int,
        )
        self._n_home_items = personality.n_home_items
        names = personality.aliases
        parameters = ParameterService(
            AliasedParameters(autopilot.parameters, names) if names else autopilot.parameters,
            partners,
            statustext,
            has_bytewise_integers=personality.has_bytewise_integers,
        )
        flight_commands = FlightCommands(view, personality, modes)
        executors = {
            **flight_commands.executors,
            **MessageCommands(self.telemetry, personality, statustext).executors,
            **FailureCommands(view, statustext).executors,
            **(self.lockstep.executors if self.lockstep else {}),
        }
        accept = guided.accept_setpoint if guided else autopilot.set_offboard_setpoint
        services: Sequence[Service] = (
            CommandService(executors, statustext),
            OldRequestService(flight_commands, self.telemetry, statustext),
            OffboardService(view, accept),
            FollowTargetService(view),
            ManualControlService(autopilot, self.system_id),
            TimesyncService(lambda: view.plant.time_us),
            AbsentService(statustext),
        )
        self._stateful: Sequence[StatefulService] = (
            GroundStationService(autopilot),
            self._missions,
            parameters,
            ShellService(view, has_shell=personality.has_shell),
            LogService(self._recorder),
            FileService(self._recorder.files),
            self.telemetry,
        )
        self._handlers: dict[int, Handler] = {
            LAYOUTS[name].message_id: handler
            for service in (*services, *self._stateful)
            for name, handler in service.handlers.items()
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
        self._view.refresh()
        self._receive(0.0)
        self._tell_events()
        self.statustext.end_tick()
        with faults:
            self._recorder.update()
        for service in self._stateful:
            for channel in tuple(service.busy):
                with faults:
                    service.update(channel)
                if faults.has_failed:
                    service.forget(channel)  # Else it would fail again at every tick.
        if self.lockstep is not None:
            self.lockstep.end_tick()
        self._n_ticks += 1
        self._flush(is_due=self._n_ticks % self._ticks_per_datagram == 0)

    def wait_for_tick(self, timeout_s: float) -> bool:
        """Answer clients until one that keeps the time grants a tick; at once without lockstep.

        Returns:
            Whether a tick may run; False if none was granted within the time.
        """
        if self.lockstep is None or self.lockstep.has_ticks:
            return True
        self._receive(timeout_s)
        self._flush()
        return self.lockstep.has_ticks

    def _receive(self, timeout_s: float) -> None:
        """Read all links, and answer what came; wait for the first bytes at most that long."""
        for key, _ in self._selector.select(timeout_s):
            with self.faults:
                key.data()
        self._meet_partners()
        for channel in self._partners.channels:
            if self.lockstep is None or not self.lockstep.holds_back(channel):
                self._answer(channel, channel.take_messages())

    def _answer(self, channel: Channel, messages: Sequence[Message]) -> None:
        for number, message in enumerate(messages, start=1):
            with self.faults:
                self._dispatch(channel, message)
            if self.lockstep is not None and self.lockstep.holds_back(channel):
                channel.put_back(messages[number:])
                return

    def _flush(self, *, is_due: bool = True) -> None:
        for channel in self._partners.channels:
            with self.faults:
                channel.flush(is_due=is_due)

    def close(self) -> None:
        """Send what still waits and release all ports. Closing twice is fine."""
        self._flush()
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
            if self.lockstep is not None:
                self.lockstep.forget(gone)
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
                self._missions.announce_reached(event.index + self._n_home_items)
            else:
                self.statustext.say(event.severity, event.text)
