"""MAVLink server of the vehicle: links, microservices and streams, polled once per tick.

Nothing that a client sends can stop the flight: work per tick is bounded for every partner,
malformed input is ignored, and an error in answering one costs that partner's message alone.
Everything runs between two ticks of the simulation, so that a run in lockstep repeats exactly.
"""

from __future__ import annotations

import contextlib
import selectors
from collections.abc import Sequence

from autonomy.types import Vector3
from flightsim.autopilot.autopilot import Autopilot
from flightsim.autopilot.events import MissionItemReached, PayloadOrder, Severity
from flightsim.frames import LocalFrame
from flightsim.mavlink.channel import Channel
from flightsim.mavlink.faults import Faults
from flightsim.mavlink.ignored_messages import IgnoredMessages, reason_for
from flightsim.mavlink.links import Link
from flightsim.mavlink.lockstep import Lockstep
from flightsim.mavlink.parsing import Message
from flightsim.mavlink.payload import PayloadComponents
from flightsim.mavlink.personalities import PX4, Personality
from flightsim.mavlink.routing import Router
from flightsim.mavlink.service import Partners, StatefulService
from flightsim.mavlink.services import Services, Setting
from flightsim.mavlink.signing import Signing
from flightsim.mavlink.statustext import StatustextSender
from flightsim.mavlink.view import VehicleView
from flightsim.payload import Payload
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
        ticks_per_burst: int = 1,
        signing: Signing | None = None,
        payload: Payload | None = None,
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
            has_lockstep: True lets a client keep the time; `wait_for_tick` then waits for it.
            ticks_per_burst: Number of ticks whose streams leave together, as long datagrams one
                behind the other, which wake their reader once; answers never wait.
            signing: Key and signatures of the links, so that clients can set the key; None if the
                links do not sign.
            payload: Camera and gimbal, updated here; None carries neither.

        Raises:
            LinkError: If a link cannot be opened; the others are closed again.
        """
        self.system_id = system_id
        self._autopilot = autopilot
        self._links = tuple(links)
        self._partners = Partners()
        self._own = (system_id, AUTOPILOT_COMPONENT)
        self._router = Router(self._partners, self._own)
        self._identified: set[Channel] = set()
        self._selector = selectors.DefaultSelector()
        self._ticks_per_burst = ticks_per_burst
        self._n_ticks = 0
        origin = local_origin_enu_m or plant.truth.position_enu_m
        self._view = VehicleView(plant, autopilot, frame, origin)
        self.lockstep = Lockstep() if has_lockstep else None
        self.statustext = StatustextSender(self._partners)
        self._ignored = IgnoredMessages(self.statustext)
        self.faults = Faults(lambda line: self.statustext.broadcast(Severity.ERROR, line))
        self._payload: PayloadComponents | None = None
        if payload is not None:
            self._payload = PayloadComponents(
                payload, self._view, self._partners, self.statustext, self.faults, self._own
            )
        services = self._services(personality, signing)
        self.telemetry = services.telemetry
        self._missions, self._watching = services.missions, services.watching
        self._n_home_items = personality.n_home_items
        self._stateful, self._handlers = services.stateful, services.handlers
        self._common = services.common
        self._open_links()

    def _services(self, personality: Personality, signing: Signing | None) -> Services:
        return Services(
            Setting(
                view=self._view,
                partners=self._partners,
                statustext=self.statustext,
                personality=personality,
                system_id=self.system_id,
                signing=signing,
                lockstep=self.lockstep,
                faults=self.faults,
                payload=self._payload,
            )
        )

    def _open_links(self) -> None:
        with contextlib.ExitStack() as opened:
            # Closes the links that are open already if one fails.
            for link in self._links:
                link.open(self._selector, lambda: self._view.time_us)
                opened.callback(link.close)
            opened.pop_all()

    @property
    def channels(self) -> Sequence[Channel]:
        """All present partners."""
        return self._partners.channels

    def update(self) -> None:
        """Read, answer, stream and send; call once every 20 ms of simulated time.

        The order keeps delays short: requests first, then events, due work of services and streams,
        and the grant of lockstep last, so that its acknowledgement follows all telemetry of the
        tick.
        """
        attempt = self.faults.attempt
        self._receive(0.0)
        self._send_events()
        self.statustext.end_tick()
        for watching in self._watching:
            attempt(watching.update)
        for service in self._stateful:
            if service.busy:
                self._work(service)
        for common in self._common:
            attempt(common.update)
        if self.lockstep is not None:
            self.lockstep.end_tick()
        self._n_ticks += 1
        self._flush(with_streams=self._n_ticks % self._ticks_per_burst == 0)
        if self._payload is not None:
            attempt(self._payload.work)  # pictures take their time, and answers do not wait for it

    def _work(self, service: StatefulService) -> None:
        """Perform a service's due work, for all partners whose transport does not lag behind."""
        faults = self.faults
        for channel in [channel for channel in service.busy if not channel.is_crowded]:
            with faults:
                service.update(channel)
            if faults.has_failed:
                service.forget(channel)  # else it would fail again at every tick

    def wait_for_tick(self, timeout_s: float) -> bool:
        """Answer clients until the one that keeps the time grants a tick; at once without lockstep.

        Args:
            timeout_s: Longest wait for a message, s of wall time.

        Returns:
            True if a tick may run, False if none was granted within the time.
        """
        if self.lockstep is None or self.lockstep.has_ticks:
            return True
        self._receive(timeout_s)
        self._flush()
        return self.lockstep.has_ticks

    def _receive(self, timeout_s: float) -> None:
        """Read all links and answer the messages; wait for the first bytes at most `timeout_s`."""
        for key, _ in self._selector.select(timeout_s):
            with self.faults:
                key.data()
        self._meet_partners()
        for channel in self._partners.channels:
            if self.lockstep is not None and self.lockstep.holds_back(channel):
                continue
            if messages := channel.take_messages():
                self._answer(channel, messages)

    def _answer(self, channel: Channel, messages: Sequence[Message]) -> None:
        # A grant within the messages ends them: the rest is answered after its ticks.
        for number, message in enumerate(messages, start=1):
            with self.faults:
                self._dispatch(channel, message)
            if self.lockstep is not None and self.lockstep.holds_back(channel):
                channel.put_back(messages[number:])
                return

    def _flush(self, *, with_streams: bool = True) -> None:
        for channel in self._partners.channels:
            if with_streams or not channel.can_wait:
                self.faults.attempt(channel.flush)

    def close(self) -> None:
        """Send all queued frames and release all ports. Closing twice is fine."""
        self._flush()
        for link in self._links:
            link.close()
        self._selector.close()

    def _meet_partners(self) -> None:
        channels = [channel for link in self._links for channel in link.channels]
        # Links keep the order, so that an unchanged list means unchanged partners.
        if channels == self._partners.channels:
            return
        for gone in self._identified.difference(channels):
            for service in (*self._stateful, *self._common):
                service.forget(gone)
            self._router.forget(gone)
            self._ignored.forget(gone)
            if self.lockstep is not None:
                self.lockstep.forget(gone)
        for channel in channels:
            channel.system_id = self.system_id
            if self._ticks_per_burst > 1:
                channel.lengthen_datagrams()
        self._identified = set(channels)
        self._partners.channels = channels

    def _dispatch(self, channel: Channel, message: Message) -> None:
        sender = (message.get_srcSystem(), message.get_srcComponent())
        # Our own frame came back through a partner that routes: answering it would go round for
        # ever.
        if sender == self._own:
            return
        self._router.route(channel, message)
        # Routed already if it is for another system.
        if getattr(message, "target_system", 0) not in {0, self.system_id}:
            return
        reason: str | None = None
        component = getattr(message, "target_component", 0)
        if component in {0, AUTOPILOT_COMPONENT}:
            handler = self._handlers.get(message.get_msgId())
            reason = handler(channel, message) if handler else reason_for(message)
        elif self._payload is not None:
            reason = self._payload.handle(component, channel, message)
        if reason:
            self._ignored.explain(channel, message, reason)

    def _send_events(self) -> None:
        for event in self._autopilot.pop_events():
            if isinstance(event, MissionItemReached):
                # ArduPilot's clients count home as item 0.
                self._missions.announce_reached(event.index + self._n_home_items)
            elif isinstance(event, PayloadOrder):
                if self._payload is not None:
                    self._payload.perform(event.item)
            else:
                self.statustext.broadcast(event.severity, event.text)
