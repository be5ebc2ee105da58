import re

import pytest
import torch

from aeroscene.learning.training.devices import DeviceError, choose_device, naming_memory

CPU = torch.device("cpu")


def test_auto_is_a_device_that_works():
    device = choose_device("auto")
    assert torch.ones(2, device=device).sum() == 2
    assert choose_device("cpu") == CPU


@pytest.mark.parametrize("name", ["cuda:77", "tpu", "", "cpu:x", "CPU"])
def test_device_that_is_not_there_is_named_beside_those_that_are(name):
    pattern = rf"device {re.escape(repr(name))} is not there, valid here: auto, cpu"
    with pytest.raises(DeviceError, match=pattern):
        choose_device(name)


def test_real_lack_of_memory_says_what_needs_less():
    with (
        pytest.raises(DeviceError, match="'cpu' is out of memory; valid: a smaller batch"),
        naming_memory(CPU, "a smaller batch"),
    ):
        torch.empty(2**52, dtype=torch.uint8)


@pytest.mark.parametrize("error", [MemoryError(), torch.OutOfMemoryError("CUDA out of memory")])
def test_every_kind_of_lack_is_known(error):
    with pytest.raises(DeviceError, match="out of memory"), naming_memory(CPU, "less"):
        raise error


def test_other_faults_are_not_taken_for_it():
    with pytest.raises(RuntimeError, match="shapes"), naming_memory(CPU, "less"):
        raise RuntimeError("shapes do not fit")
