"""Messages between clients: to all, to a system, to a component, never back, in either version."""

import pytest

from flightsim.mavlink.dialect import LAYOUTS
from flightsim.mavlink.links import InProcessLink
from flightsim.mavlink.routing import Router
from flightsim.mavlink.server import MavlinkServer
from flightsim.mavlink.service import Partners
from tests.flightsim.mavlink.wire import Loop, Wire, named

STATION, TABLET, CAMERA = (255, 190), (254, 1), (1, 100)


class Net:
    """A server with a ground station, a tablet and a companion's camera, each on its own link."""

    def __init__(self, flight, *, is_version_1=()):
        self.flight = flight
        self.links = [InProcessLink() for _ in range(3)]
        self.server = MavlinkServer(flight.autopilot, flight.plant, flight.frame, self.links)
        addresses = (STATION, TABLET, CAMERA)
        self.wires = [Wire(*address, is_version_1=address in is_version_1) for address in addresses]
        for index in range(3):
            self.send(index, "HEARTBEAT", 6, 8, 0, 0, 4, 3)
        self.step()

    def send(self, index, name, *values):
        self.links[index].client.send(self.wires[index].encode(name, *values))

    def step(self):
        """What each client hears of the others in a tick."""
        self.flight.plant.advance()
        self.server.update()
        came = []
        for link, wire in zip(self.links, self.wires, strict=True):
            messages = wire.decode(link.client.recv())
            sources = [(m, (m.get_srcSystem(), m.get_srcComponent())) for m in messages]
            came.append([message for message, source in sources if source != (1, 1)])
        return came


@pytest.fixture
def net(flight):
    net = Net(flight)
    yield net
    net.server.close()


def _types(came):
    return [[message.get_type() for message in messages] for messages in came]


def test_what_is_for_nobody_in_particular_goes_to_all_others(net):
    net.send(0, "HEARTBEAT", 6, 8, 0, 0, 4, 3)
    came = net.step()
    assert _types(came) == [[], ["HEARTBEAT"], ["HEARTBEAT"]]
    (message,) = came[1]
    assert (message.get_srcSystem(), message.get_srcComponent()) == STATION


@pytest.mark.parametrize(
    ("target", "heard"),
    [
        (CAMERA, [[], [], ["COMMAND_LONG"]]),
        ((1, 0), [[], [], ["COMMAND_LONG"]]),  # for the vehicle too
        (TABLET, [[], ["COMMAND_LONG"], []]),
        ((254, 0), [[], ["COMMAND_LONG"], []]),
        ((0, 0), [[], ["COMMAND_LONG"], ["COMMAND_LONG"]]),
        (STATION, [[], [], []]),  # never back
        ((1, 1), [[], [], []]),
        ((1, 101), [[], [], []]),
        ((9, 1), [[], [], []]),
    ],
)
def test_a_command_goes_where_its_target_was_heard(net, target, heard):
    net.send(0, "COMMAND_LONG", *target, 2000, 0, *(0,) * 7)
    assert _types(net.step()) == heard


def test_the_vehicle_answers_what_is_for_it_and_for_others(net):
    net.send(0, "COMMAND_LONG", 0, 0, 512, 0, LAYOUTS["HEARTBEAT"].message_id, *(0,) * 6)
    net.server.update()
    answered = net.wires[0].decode(net.links[0].client.recv())
    assert [ack.command for ack in named(answered, "COMMAND_ACK")] == [512]


def test_an_answer_finds_its_way_back(net):
    net.send(2, "COMMAND_ACK", 2000, 0, 0, 0, *STATION)
    came = net.step()
    assert _types(came) == [["COMMAND_ACK"], [], []]


def test_what_a_radio_says_of_itself_and_keys_stay_on_their_link(net):
    net.send(0, "RADIO_STATUS", 0, 0, 0, 0, 0, 0, 0)
    net.send(0, "SETUP_SIGNING", *TABLET, [1] * 32, 0)
    assert _types(net.step()) == [[], [], []]


def test_sticks_for_another_system_go_there(net):
    net.send(0, "MANUAL_CONTROL", 254, 0, 0, 500, 0, 0)
    assert _types(net.step()) == [[], ["MANUAL_CONTROL"], []]


def test_a_frame_goes_on_as_it_came(net):
    frame = net.wires[0].encode("PARAM_SET", *TABLET, b"ANY", 1.5, 9)
    net.links[0].client.send(frame)
    (message,) = net.step()[1]
    assert bytes(message.get_msgbuf()) == frame


def test_a_partner_that_speaks_mavlink_1_reads_what_others_say_in_2(flight):
    net = Net(flight, is_version_1=(TABLET,))
    net.send(0, "PARAM_SET", *TABLET, b"ANY", 1.5, 9)
    net.send(0, "TUNNEL", *TABLET, 0, 0, [0] * 128)  # has no MAVLink 1 id
    net.send(1, "PARAM_SET", *STATION, b"OTHER", 0.0, 9)
    station, tablet, _ = net.step()
    assert _types([station, tablet]) == [["PARAM_SET"], ["PARAM_SET"]]
    assert tablet[0].get_msgbuf()[0] == 0xFE
    assert (tablet[0].param_id, tablet[0].param_value) == ("ANY", 1.5)
    assert tablet[0].get_srcSystem() == 255
    assert station[0].param_id == "OTHER"
    net.server.close()


def test_a_partner_that_left_is_forgotten_and_what_is_known_of_one_is_bounded():
    partners = Partners()
    router = Router(partners, (1, 1))
    loops = [Loop(), Loop()]
    partners.channels = [loop.channel for loop in loops]
    for component in range(200):
        wire = Wire(7, component)
        (message,) = wire.decode(wire.encode("PING", 0, 0, 3, 3))
        router.route(loops[0].channel, message)
    assert len(router._heard[loops[0].channel]) == 64

    def arrives():
        wire = Wire(*STATION)
        (message,) = wire.decode(wire.encode("PING", 0, 0, 7, 0))
        router.route(loops[1].channel, message)
        return bool(loops[0].answers())

    assert arrives()
    router.forget(loops[0].channel)
    assert not arrives()
