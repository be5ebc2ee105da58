"""Batches made ahead: the same, once each, with their errors."""

import threading

import pytest
import torch

from aeroscene.learning.training.batches.opened import Supply, open_batches
from aeroscene.learning.training.batches.prefetch import Prefetched
from aeroscene.learning.training.batches.source import drawn_from
from aeroscene.learning.training.config import TrainCfg

CPU = torch.device("cpu")


def test_batches_are_the_same_ones_each_made_once_in_a_thread(data):
    plain = drawn_from(data.train, 4, seed=3)
    made = []

    def noted(step):
        made.append((step, threading.current_thread() is threading.main_thread()))
        return plain(step)

    with Prefetched(noted, CPU) as ahead:
        for step in range(5, 12):
            batch = ahead(step)
            assert torch.equal(batch.x0, plain(step).x0)
    assert [step for step, _ in made] == list(range(5, 5 + len(made)))
    assert 7 <= len(made) <= 9
    assert not any(is_main for _, is_main in made)


def test_next_batch_is_made_while_this_one_is_used(data):
    plain, is_made = drawn_from(data.train, 4, seed=0), threading.Event()

    def noted(step):
        if step == 1:
            is_made.set()
        return plain(step)

    with Prefetched(noted, CPU) as ahead:
        ahead(0)
        assert is_made.wait(20.0)


def test_error_reaches_the_step_that_it_belongs_to(data):
    plain = drawn_from(data.train, 4, seed=0)

    def broken(step):
        if step == 2:
            raise OSError("no scenes")
        return plain(step)

    with Prefetched(broken, CPU) as ahead:
        ahead(0)
        ahead(1)
        with pytest.raises(OSError, match="no scenes"):
            ahead(2)


@pytest.mark.parametrize(("name", "is_ahead"), [("cpu", False), ("meta", True)])
def test_thread_works_ahead_where_another_device_computes(data, tmp_path, name, is_ahead):
    device = torch.device(name)
    supply = Supply(
        scenes=data.train,
        encode=data.train.encoder,
        last_number=None,
        folder=tmp_path,
        n_workers=1,
        stage="denoiser",
        is_last=True,
    )
    with open_batches(supply, TrainCfg(), device, 0, lambda: False) as opened:
        assert isinstance(opened.batches, Prefetched) == is_ahead
        assert opened.batches(0).x0.device == (device if is_ahead else CPU)
