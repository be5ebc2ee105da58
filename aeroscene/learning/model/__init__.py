"""The hierarchical denoiser of programs: noisy channels in, predicted noise, velocity or x0 out."""
