"""Training: data, skeleton model, denoiser, semantic prior; checkpoints, resuming, curves.

`procedure.train` joins them; `loop` is the paper's training algorithm for the denoiser.
"""
