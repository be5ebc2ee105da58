"""OPTICAL_FLOW_RAD comes from a vehicle that carries the sensor, and from no other."""

import pytest

from flightsim.mavlink.dialect import LAYOUTS
from flightsim.mavlink.dialect import dialect as mav
from flightsim.testbench import Testbench, TestbenchCfg
from tests.flightsim.handmade import empty_scene
from tests.flightsim.mavlink.wire import Wire, named


@pytest.mark.parametrize("is_fitted", [False, True])
def test_the_flow_is_told_where_there_is_a_sensor(is_fitted):
    cfg = TestbenchCfg(speed="max", optical_flow=is_fitted)
    message_id = LAYOUTS["OPTICAL_FLOW_RAD"].message_id
    with Testbench(empty_scene(), cfg, has_network=False) as bench:
        pipe, wire = bench.stack.pipe(), Wire()
        pipe.send(
            wire.encode(
                "COMMAND_LONG",
                1,
                1,
                mav.MAV_CMD_SET_MESSAGE_INTERVAL,
                0,
                message_id,
                50_000,
                *[0] * 5,
            )
        )
        heard = []
        for _ in range(100):
            bench.simulator.step()
            heard += wire.decode(pipe.recv())
        reading = bench.plant.sensors.optical_flow
    (answer,) = named(heard, "COMMAND_ACK")
    flows = named(heard, "OPTICAL_FLOW_RAD")
    assert bool(flows) == is_fitted
    assert (answer.result == mav.MAV_RESULT_ACCEPTED) == is_fitted
    if is_fitted:
        assert len(flows) > 20
        last = flows[-1]
        assert last.integration_time_us == 20_000
        assert last.distance == pytest.approx(0.11, abs=0.01)
        assert last.quality == 255
        assert reading.integration_us == 20_000
        assert last.integrated_zgyro == pytest.approx(reading.gyro_frd_rad[2], abs=1e-3)
