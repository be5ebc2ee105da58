"""Training: data, writer, denoiser and priors; checkpoints, resuming, curves.

`procedure.train` joins them; `loop` is the paper's training algorithm for the denoiser.
"""
