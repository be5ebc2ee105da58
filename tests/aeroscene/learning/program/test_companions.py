"""What units stand beside: learnt from scenes, kept when a drawn rank says something else."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from aeroscene.corpus.curation import curate_layout
from aeroscene.learning.program import DecodingCfg, decode, encode
from aeroscene.learning.program.companions import bond_of, measure_companions
from aeroscene.learning.program.decoding.units.reading import read_unit
from aeroscene.learning.program.kinds import UnitKind

AS_DRAWN = DecodingCfg(mends=False, makes_room=False)
CUP = UnitKind("unit", "cup", relation="SIDE", gap="NEAR", align="FREE", turn=4)


def test_hosts_of_a_bond_are_those_that_it_often_has():
    pairs = [(CUP, "laptop SIDE")] * 60 + [(CUP, "plate EDGE")] * 39 + [(CUP, "fence SIDE")]
    known = measure_companions(pairs)
    assert known.by_bond == {bond_of(CUP): ("laptop SIDE", "plate EDGE")}
    hosts = ["fence SIDE", "plate EDGE", "fence SIDE", "laptop SIDE"]
    assert [known.nearest(CUP, rank, hosts) for rank in range(4)] == [1, 1, 1, 3]


def test_what_is_seldom_or_has_no_choice_keeps_its_host():
    known = measure_companions([(CUP, "laptop SIDE")] * 19)
    assert known.nearest(CUP, 1, ["laptop SIDE", "fence SIDE"]) == 1
    known = measure_companions([(CUP, "laptop SIDE")] * 30)
    assert known.nearest(CUP, 1, ["fence SIDE", "fence EDGE"]) == 1


@cache
def corpus():
    return tuple(encode(curate_layout(number)) for number in range(24))


def hosts_found(program, monkeypatch):
    """Each unit's kind with what it came to stand beside, where it had a choice."""
    found = []

    def watched(making, token, bearer, last_m=None, **options):
        unit = read_unit(making, token, bearer, last_m, **options)
        found.append((making.program.kinds[token], making.host_key(unit.host_id)))
        return unit

    monkeypatch.setattr("aeroscene.learning.program.decoding.decode.read_unit", watched)
    decode(program, cfg=AS_DRAWN)
    return found


@pytest.mark.parametrize("knows", [True, False])
def test_units_of_other_ranks_stand_beside_what_such_units_do(monkeypatch, knows):
    pairs = [
        (kind, host)
        for each in corpus()
        for kind, host in zip(each.program.kinds, each.hosts, strict=True)
        if kind.node == "unit"
    ]
    companions = measure_companions(20 * pairs)
    rng = np.random.default_rng(2)
    strange = []
    for each in corpus()[:8]:
        program = replace(each.program, host=rng.permutation(each.program.host))
        program = replace(program, companions=companions) if knows else program
        for kind, host in hosts_found(program, monkeypatch):
            known = companions.by_bond.get(bond_of(kind))
            if known is not None and kind.relation == "SIDE" and kind.category != "stairs":
                strange.append(host not in known)
    assert len(strange) > 50
    assert (np.mean(strange) < 0.05) == knows


def test_what_was_read_off_a_scene_is_decoded_to_the_same_hosts(monkeypatch):
    for each in corpus()[:4]:
        found = hosts_found(each.program, monkeypatch)
        read = [
            (kind, host)
            for kind, host in zip(each.program.kinds, each.hosts, strict=True)
            if kind.node == "unit"
        ]
        assert sorted(map(repr, found)) == sorted(map(repr, read))
