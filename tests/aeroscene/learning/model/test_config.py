"""What a configuration may say."""

from __future__ import annotations

import pytest

from aeroscene.learning.model.config import ModelCfg, ModelCfgError
from aeroscene.learning.training.paper_preset import paper_cfg


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"width": 0}, "width 0 is out of range; valid: 1 to 4096"),
        ({"blocks": 99999}, "blocks 99999 is out of range; valid: 1 to 64"),
        ({"heads": 3}, "heads is 3 with width 128; valid: an even number"),
        ({"width": 100, "heads": 8}, "heads is 8 with width 100"),
        ({"place_width": 7}, "place_width is 7; valid: even numbers, 2 to 256"),
        ({"channels": 20, "n_categories": 7}, "channels is 20 with n_categories 7; valid: 10"),
        ({"grid_reach": 0.0}, "grid_reach 0.0 is out of range; valid: above 0"),
        ({"graph_radius": -1.0}, "graph_radius -1.0 is out of range; valid: above 0"),
        ({"grid_shape": (4, 1, 4)}, "grid_shape 1 is out of range; valid: 2 to 64"),
        ({"unet_widths": ()}, r"unet_widths is \(\); valid: one width or more"),
        ({"unet_widths": (18,)}, "unet_widths is 18; valid: multiples of heads, 4"),
        ({"routing": "learned"}, "the other parts need denoiser unet"),
        ({"denoiser": "gru"}, "denoiser is 'gru'; valid: 'unet', 'tokens'"),
        ({"routing": "magic"}, "routing is 'magic'; valid: 'learned', 'given'"),
    ],
)
def test_out_of_range_is_named_with_what_would_be_valid(wrong: dict, message: str) -> None:
    with pytest.raises(ModelCfgError, match=message):
        ModelCfg(**wrong)


def test_presets_are_valid() -> None:
    assert ModelCfg().denoiser == "tokens"
    paper = paper_cfg(70)
    assert (paper.denoiser, paper.routing) == ("unet", "learned")
    assert (paper.coarse_branch, paper.fine_branch) == ("cnn", "radius_gnn")
