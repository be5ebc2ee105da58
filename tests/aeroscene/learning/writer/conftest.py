"""Whole scenes and a small writer of their programs."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from aeroscene.learning.wishes import Wish
from aeroscene.learning.writer.config import WriterCfg
from aeroscene.learning.writer.examples import encodable
from aeroscene.learning.writer.language import Language, learn_language
from aeroscene.learning.writer.model import Writer, new_writer
from tests.aeroscene.conftest import cached_scene

NUMBERS = (1, 42, 49, 311, 14, 27)


@pytest.fixture(scope="session")
def corpus():
    """Programs of scenes, and what these have."""
    return encodable([cached_scene(number) for number in NUMBERS])


@pytest.fixture(scope="session")
def language(corpus) -> Language:
    return learn_language(corpus[0])


@pytest.fixture(scope="session")
def writer(language) -> Writer:
    torch.manual_seed(0)
    return new_writer(WriterCfg(width=16, kind_width=8, layers=2), language).eval()


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(5)


@pytest.fixture(params=("outdoor", "indoor", "mixed"))
def wish(request, corpus) -> Wish:
    return next(each for each in corpus[1] if each.domain == request.param)
