"""A node in a process of its own: hears every topic, and may fly by velocities.

    python -m tests.scenarios.ros2.listener dds|zenoh DOMAIN PORT OUT [fly]

It knows nothing of the door: types, CDR and hashes are ros2_pyterfaces'. It prints `ready` once it
hears, and `over` when its input closes or when it has landed; then it writes what it heard to OUT.
"""

import pickle
import select
import struct
import sys
import time
from pathlib import Path

from ros2_pyterfaces.core.types import Array, Sequence

from tests.scenarios.ros2.kinds import LATCHED, TOPICS, kind_named

WHOLE = {"/clock", *LATCHED}
"""Topics of which all messages are decoded; of the others, some all along the flight."""
MOST = 40


class DdsNode:
    def __init__(self, domain, _):
        from cyclonedds.core import Policy, Qos
        from cyclonedds.domain import Domain, DomainParticipant

        config = (
            "<CycloneDDS><Domain><General><Interfaces><NetworkInterface address='127.0.0.1'/>"
            "</Interfaces><AllowMulticast>false</AllowMulticast></General><Discovery>"
            "<ParticipantIndex>auto</ParticipantIndex><Peers><Peer address='localhost'/></Peers>"
            "</Discovery></Domain></CycloneDDS>"
        )
        self.domain, self.participant = Domain(domain, config), DomainParticipant(domain)
        best, keep = Policy.Reliability.BestEffort, Policy.History.KeepLast(5000)
        self.sensor = Qos(best, keep)
        self.reliable = Qos(Policy.Reliability.Reliable(0), keep)
        self.latched = Qos(Policy.Reliability.Reliable(0), Policy.Durability.TransientLocal, keep)
        self.readers = {}

    def subscribe(self, topic, name):
        from cyclonedds.sub import DataReader

        qos = self.latched if topic in LATCHED else self.sensor
        self.readers[topic] = DataReader(self.participant, self._topic(topic, name), qos=qos)

    def publisher(self, topic, name):
        from cyclonedds.pub import DataWriter

        made = self._topic(topic, name)
        writer = DataWriter(self.participant, made, qos=self.reliable)

        def publish(data):
            sample = object.__new__(made.data_type)
            sample.cdr = data
            writer.write(sample)

        return publish

    def take(self):
        for topic, reader in self.readers.items():
            for sample in reader.take(1000):
                if hasattr(sample, "cdr"):
                    yield topic, sample.cdr

    def is_ready(self):
        return all(reader.get_matched_publications() for reader in self.readers.values())

    def _topic(self, topic, name):
        from cyclonedds.topic import Topic

        kind = _idl(kind_named(name).to_core_schema())
        kind.serialize = lambda sample, **_: sample.cdr

        def deserialize(_, data, **__):
            sample = object.__new__(kind)
            sample.cdr = bytes(data)
            return sample

        kind.deserialize = classmethod(deserialize)
        return Topic(self.participant, f"rt{topic}", kind)


def _idl(schema):
    """A type of Cyclone DDS for a schema of ros2_pyterfaces."""
    from cyclonedds.idl import make_idl_struct, types

    if isinstance(schema, str):
        return {"string": str, "bool": bool}.get(schema) or getattr(types, schema)
    if isinstance(schema, Array):
        return types.array[_idl(schema.subtype), schema.length]
    if isinstance(schema, Sequence):
        return types.sequence[_idl(schema.subtype)]
    package, folder, last = schema["__typename"].split("/")
    fields = {name: _idl(kind) for name, kind in schema.items() if name != "__typename"}
    return make_idl_struct(last, f"{package}.{folder}.dds_.{last}_", fields)


class ZenohNode:
    def __init__(self, domain, port):
        import zenoh

        config = zenoh.Config()
        config.insert_json5("mode", '"peer"')
        config.insert_json5("connect/endpoints", f'["tcp/127.0.0.1:{port}"]')
        config.insert_json5("listen/endpoints", '["tcp/127.0.0.1:0"]')
        config.insert_json5("scouting/multicast/enabled", "false")
        self.zenoh, self.domain = zenoh, domain
        self.session = zenoh.open(config)
        self.queues, self.kept = {}, []

    def subscribe(self, topic, name):
        from zenoh.ext import HistoryConfig, declare_advanced_subscriber

        queue, key = self.zenoh.handlers.RingChannel(5000), self._key(topic, name)
        if topic in LATCHED:
            history = HistoryConfig(detect_late_publishers=True)
            found = declare_advanced_subscriber(self.session, key, queue, history=history)
        else:
            found = self.session.declare_subscriber(key, queue)
        self.queues[topic] = found

    def publisher(self, topic, name):
        publisher = self.session.declare_publisher(self._key(topic, name))
        self.kept.append(publisher)
        # As rmw_zenoh attaches it: number, time in ns, length of the sender's id, the id.
        return lambda data: publisher.put(data, attachment=struct.pack("<qqB16s", 1, 2, 16, b"me"))

    def take(self):
        for topic, queue in self.queues.items():
            while (sample := queue.try_recv()) is not None:
                yield topic, sample.payload.to_bytes()

    def is_ready(self):
        time.sleep(1.0)
        return True

    def _key(self, topic, name):
        package, folder, last = name.split("/")
        kind = f"{package}::{folder}::dds_::{last}_"
        return f"{self.domain}{topic}/{kind}/{kind_named(name).hash_rihs01()}"


class Pilot:
    """Arms, climbs to 3 m, flies east for 2 s and lands: a loop over odometry and /cmd_vel."""

    def __init__(self, node):
        twist, self.bool = (
            kind_named("geometry_msgs/msg/TwistStamped"),
            kind_named("std_msgs/msg/Bool"),
        )
        self.twist, self.empty = twist, kind_named("std_msgs/msg/Empty")
        self.fly = node.publisher("/cmd_vel", "geometry_msgs/msg/TwistStamped")
        self.arm = node.publisher("/command/arm", "std_msgs/msg/Bool")
        self.land = node.publisher("/command/land", "std_msgs/msg/Empty")
        self.phase, self.armed, self.at, self.due, self.east_s = "climb", "", None, 0.0, 0.0
        self.was_armed = False

    @property
    def is_landed(self):
        return self.phase == "landing" and self.armed == "disarmed"

    def hear(self, topic, data):
        if topic == "/odometry/estimate":
            self.at = kind_named(TOPICS[topic]).deserialize(data)
        elif topic == "/armed":
            self.armed = kind_named(TOPICS[topic]).deserialize(data).data
        elif topic == "/clock" and self.at is not None and self.phase != "landing":
            now = kind_named(TOPICS[topic]).deserialize(data).clock
            self.step(now.sec + 1e-9 * now.nanosec)

    def step(self, now_s):
        if now_s < self.due:
            return
        self.due = now_s + 0.05
        command = self.twist()
        command.header.frame_id = "map"
        if self.phase == "climb":
            command.twist.linear.z = 1.5
            if self.armed != "armed":
                self.arm(self.bool(data=True).serialize())
            if self.at.pose.pose.position.z > 3.0:
                self.phase, self.east_s = "east", now_s
        else:
            command.twist.linear.x = 2.0
            if now_s > self.east_s + 2.0:
                self.phase = "landing"
                self.land(self.empty().serialize())
        self.fly(command.serialize())


def plain(message):
    """A message as plain data; its bytes stay one piece, for a list is walked number by number."""
    if not isinstance(content := getattr(message, "data", None), (bytes, list)):
        return message.to_core_message()
    message.data = []
    return message.to_core_message() | {"data": content}


def say(word):
    sys.stdout.write(f"{word}\n")
    sys.stdout.flush()


def main(transport, domain, port, out, *rest):
    node = (DdsNode if transport == "dds" else ZenohNode)(int(domain), int(port))
    for topic, name in TOPICS.items():
        node.subscribe(topic, name)
    pilot = Pilot(node) if rest else None
    while not node.is_ready():
        time.sleep(0.05)
    say("ready")
    heard = {topic: [] for topic in TOPICS}
    while not (pilot and pilot.is_landed) and not select.select([sys.stdin], [], [], 0)[0]:
        for topic, data in node.take():
            heard[topic].append(data)
            if pilot:
                pilot.hear(topic, data)
        time.sleep(0.001)
    say("over")
    decoded = {
        topic: [
            plain(kind_named(TOPICS[topic]).deserialize(each))
            for each in (found if topic in WHOLE else found[:: 1 + 2 * (len(found) // (2 * MOST))])
        ]
        for topic, found in heard.items()
    }
    Path(out).write_bytes(pickle.dumps(decoded))


if __name__ == "__main__":
    main(*sys.argv[1:])
