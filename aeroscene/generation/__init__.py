"""From a seed to a scene: skeleton, guided diffusion, feasibility."""
