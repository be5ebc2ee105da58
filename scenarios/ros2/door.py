"""The door to ROS 2 of one run, which opens a transport and publishes every vehicle on it.

The door is a set of observers of the simulation loop. They run after each tick, poll commands and
publish states in the same thread. A flight is therefore the same with the door and without it, as
long as no node commands, and no node can delay it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal, Self

from flightsim.cameras import RgbdFrame
from flightsim.lidars import LidarScan
from flightsim.mavlink.client import MavlinkClient
from flightsim.simulator import Observer
from flightsim.testbench import TestbenchError, Vehicle
from flightsim.vehicles.builder import vehicle_name
from scenarios.ros2.camera_topics import CameraTopics
from scenarios.ros2.clouds import cloud
from scenarios.ros2.commands import Commands
from scenarios.ros2.fixed_topics import announce
from scenarios.ros2.frames import BASE
from scenarios.ros2.messages import RosMessages, RosMissingError
from scenarios.ros2.state_topics import StateTopics
from scenarios.ros2.topics import Topics
from scenarios.ros2.transport import SENSOR, Transport, TransportError

TransportName = Literal["dds", "zenoh"]


@dataclass(frozen=True, kw_only=True, eq=False)
class Guest:
    """A vehicle of the run, with the functions that the door needs."""

    vehicle: Vehicle
    render: Callable[[str], RgbdFrame]
    """Function that renders the present frame of a camera; the first call opens the cameras."""
    connect: Callable[[], MavlinkClient] | None
    """Function that connects a companion; None if a pilot of this process flies, whom nodes only
    watch."""


class Ros2Door:
    """Publishes a run and passes commands on.

    Attributes:
        observers: Functions to call after each tick, in order.
    """

    def __init__(
        self,
        guests: Sequence[Guest],
        *,
        transport: TransportName,
        domain: int,
        address: str,
        instance: int,
        camera_hz: float,
    ) -> None:
        """Join a domain.

        Args:
            guests: Vehicles of the run; the first one has no namespace.
            transport: Name of the transport.
            domain: Number of the domain, as in ROS_DOMAIN_ID.
            address: Address to listen on; 127.0.0.1 keeps everything on this machine.
            instance: Number that is added to the port of the Zenoh router.
            camera_hz: Frames of each camera in a simulated second; 0 offers no cameras.

        Raises:
            TestbenchError: If a library is missing, or the transport cannot be opened.
        """
        try:
            ros = RosMessages("ros2")
            self._transport = _open(transport, domain, address, instance, ros)
        except (RosMissingError, TransportError) as error:
            raise TestbenchError(f"ros2 {error}") from None
        self.observers: list[Observer] = []
        # A door that fails halfway must leave the domain, or its topics would stay announced.
        try:
            self._announce(guests, ros, camera_hz)
        except BaseException:
            self.close()
            raise

    def _announce(self, guests: Sequence[Guest], ros: RosMessages, camera_hz: float) -> None:
        """Offer every topic and service, and publish fixed transforms and areas."""
        parts: list[tuple[Topics, Guest]] = []
        for guest in guests:
            number = guest.vehicle.plant.world.number
            # Without a namespace for the first, one vehicle looks as nodes usually expect it.
            prefix = f"{vehicle_name(number)}/" if number else ""
            parts.append((Topics(self._transport, ros, prefix), guest))
        for topics, guest in parts:
            self._publish(topics, guest, camera_hz)
        scene = guests[0].vehicle.scene
        announce([(topics, guest.vehicle.airframe) for topics, guest in parts], scene)

    def _publish(self, topics: Topics, guest: Guest, camera_hz: float) -> None:
        vehicle, plant = guest.vehicle, guest.vehicle.plant
        if guest.connect is not None:
            commands = Commands(topics, self._transport, guest.connect)
            self.observers.append(lambda: commands.on_tick(plant.time_us))
        states = StateTopics(topics, plant, vehicle.frame, vehicle.stack.reports)
        self.observers.append(states.on_tick)
        cameras = vehicle.airframe.rgbd_cameras if camera_hz > 0 else ()
        for mount in cameras:
            camera = CameraTopics(
                topics,
                plant,
                mount.name,
                guest.render,
                rate_hz=camera_hz,
                has_segments=vehicle.cfg.segmentation,
            )
            self.observers.append(camera.on_tick)
        if vehicle.lidar is not None:
            vehicle.lidar.listeners.append(_scan_listener(topics))

    def close(self) -> None:
        """Leave the domain."""
        self._transport.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()


def _scan_listener(topics: Topics) -> Callable[[LidarScan], None]:
    points = topics.publisher("lidar/points", "sensor_msgs/PointCloud2", SENSOR)
    ros, base = topics.ros, topics.frame(BASE)

    def on_scan(scan: LidarScan) -> None:
        points.offer(lambda: cloud(ros, ros.header(scan.time_us, base), scan.points_flu_m))

    return on_scan


def _open(
    name: TransportName, domain: int, address: str, instance: int, ros: RosMessages
) -> Transport:
    """Open a transport, and load only its own library."""
    if name == "zenoh":
        from scenarios.ros2.zenoh_transport import ZenohTransport

        return ZenohTransport(domain, address, instance)
    from scenarios.ros2.dds import DdsTransport

    return DdsTransport(domain, address, ros.store.fielddefs)
