"""Which guidance acts while a layout is sampled: every part is a switch."""

from __future__ import annotations

from dataclasses import dataclass, field

import torch

from aeroscene.learning.diffusion.sampling import Guidance
from aeroscene.learning.guidance.alignment import AlignmentCfg, AlignmentGuidance
from aeroscene.learning.guidance.borders import BorderGuidance, BordersCfg, GuidanceChain
from aeroscene.learning.guidance.separation import SeparationCfg, SeparationGuidance
from aeroscene.learning.paper.guidance.layout import tree_reader
from aeroscene.learning.paper.guidance.objectives import Objectives, ObjectivesCfg
from aeroscene.learning.tokens.decode import TreeDecoder
from aeroscene.learning.tokens.kinds import Vocabulary


@dataclass(frozen=True, kw_only=True)
class GuidanceCfg:
    """Parts of the guidance of our model, in the order in which they act; None is without.

    docs/notebook.md says what each of them brings.
    """

    borders: BordersCfg | None = field(default_factory=BordersCfg)
    """Borders that meet, and parts of a building within it; with no steps only the latter."""
    alignment: AlignmentCfg | None = field(default_factory=AlignmentCfg)
    """Siblings that nearly share a line share it."""
    separation: SeparationCfg | None = field(default_factory=SeparationCfg)
    """Overlaps undone by penetration depth, with hops at the last step."""
    objectives: ObjectivesCfg | None = None
    """The paper's L_guide on x_t, without its semantic term: our model has no prior."""


NO_GUIDANCE = GuidanceCfg(borders=None, alignment=None, separation=None)


def guidance_of(
    cfg: GuidanceCfg, decoder: TreeDecoder, vocabulary: Vocabulary, device: torch.device
) -> Guidance | None:
    """The parts that a configuration asks for, in a chain; None where there are none."""
    parts: list[Guidance] = []
    if cfg.borders is not None:
        parts.append(BorderGuidance(decoder, vocabulary, device, cfg.borders))
    if cfg.alignment is not None:
        parts.append(AlignmentGuidance(decoder, vocabulary, cfg.alignment))
    if cfg.separation is not None:
        parts.append(SeparationGuidance(decoder.decode, decoder.bounds, cfg.separation))
    if cfg.objectives is not None:
        parts.append(Objectives(tree_reader(decoder, vocabulary.n_kinds), cfg.objectives))
    return GuidanceChain(parts) if parts else None
