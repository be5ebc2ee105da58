"""Hostile clients of AirSim's API end no flight."""

from fuzz_airsim import besiege
from fuzzing.rpc import RpcTraffic


def test_thousands_of_hostile_messages_cost_no_answer_and_no_flight():
    row = besiege(3000, seed=5)
    assert row["n_faults"] == 0
    assert row["n_answered"] > 300
    assert row["simulated_s"] > 0.3


def test_traffic_is_drawn_by_its_seed():
    first, again, other = (RpcTraffic(seed, ["ping"]) for seed in (1, 1, 2))
    drawn = [first.message() for _ in range(50)]
    assert drawn == [again.message() for _ in range(50)]
    assert drawn != [other.message() for _ in range(50)]
