"""The hierarchical denoiser: noisy layout in, prediction of noise, velocity or clean layout out."""

from aeroscene.learning.diffusion.loss import Prediction
from aeroscene.learning.model.config import ModelCfg, ModelCfgError
from aeroscene.learning.model.network import new_denoiser

__all__ = ["ModelCfg", "ModelCfgError", "Prediction", "new_denoiser"]
