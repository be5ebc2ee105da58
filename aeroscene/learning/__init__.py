"""The AeroScene model: tokens, skeleton, diffusion, guidance, training, generation."""
