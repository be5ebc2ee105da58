"""The trained model at work: skeleton, guided diffusion, feasibility.

The same request gives the same scene on the same device with the same batch size.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import batched
from pathlib import Path

import numpy as np
import torch
from torch import Tensor

from aeroscene.areas.needs import AreaLimits
from aeroscene.diffusion.sampling import Fixed, Moment, SamplerCfg, sample
from aeroscene.diffusion.schedule import Schedule
from aeroscene.feasibility import Feasible, FeasibilityCfg, make_feasible
from aeroscene.generation.request import Request, RequestError
from aeroscene.guidance.separation import SeparationGuidance
from aeroscene.model.network import HierarchicalDenoiser
from aeroscene.scene import Scene
from aeroscene.skeleton import SkeletonModel, sample_skeleton
from aeroscene.tokens.assembly import assemble
from aeroscene.tokens.batch import Collator, TokenBatch, slots_of
from aeroscene.tokens.channels import SIZE, Geometry
from aeroscene.tokens.decode import TreeDecoder
from aeroscene.tokens.examples import Example, encode
from aeroscene.tokens.kinds import Vocabulary
from aeroscene.tokens.skeleton import Skeleton, Wish
from aeroscene.training.checkpoint import Checkpoint, read_checkpoint
from aeroscene.training.devices import choose_device
from aeroscene.training.presets import sections_from_plain

SHIPPED_CHECKPOINT = Path(__file__).parents[1] / "checkpoints" / "aeroscene.safetensors"
