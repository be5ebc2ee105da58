"""Guidance: what pulls a layout towards plausibility while it is sampled.

The paper's section "Guidance Objectives" is `collision`, `coarse_to_fine`, `semantic`, and how it
applies them is `objectives`. Ours, on the predicted clean layout by penetration depth, is
`separation`.
"""
