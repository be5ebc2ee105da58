"""The hierarchical denoiser: noisy layout in, prediction of noise, velocity or clean layout out."""
