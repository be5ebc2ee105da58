"""One world, exported once to each format."""

import pytest

from aeroscene.corpus.curation import curate_scene
from flightsim.export.glb import write_glb
from flightsim.export.mjcf import write_mjcf
from flightsim.export.usd import write_usd
from flightsim.vehicles.catalogue import AIRFRAMES
from flightsim.world import build_world


@pytest.fixture(scope="session")
def world():
    return build_world(curate_scene(42), AIRFRAMES["iris"])


@pytest.fixture(scope="session")
def mjcf_path(world, tmp_path_factory):
    return write_mjcf(world, tmp_path_factory.mktemp("mjcf"))


@pytest.fixture(scope="session")
def glb_path(world, tmp_path_factory):
    return write_glb(world, tmp_path_factory.mktemp("glb"))


@pytest.fixture(scope="session")
def usd_path(world, tmp_path_factory):
    return write_usd(world, tmp_path_factory.mktemp("usd"))
