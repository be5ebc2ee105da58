"""The hierarchical denoiser: noisy layout in, prediction of noise, velocity or clean layout out."""

from aeroscene.learning.model.config import ModelCfg, ModelCfgError
from aeroscene.learning.model.network import HierarchicalDenoiser
from aeroscene.learning.model.prediction import Prediction

__all__ = ["HierarchicalDenoiser", "ModelCfg", "ModelCfgError", "Prediction"]
