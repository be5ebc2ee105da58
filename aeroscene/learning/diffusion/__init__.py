"""Denoising diffusion: noise schedule, what the network predicts, training loss, samplers.

Nothing here knows the meaning of a token, so that every preset and baseline uses the same code. The
paper's section "Diffusion Process" is `schedule`; its algorithms 1 and 2 are `loss` and `sampling`.

    symbol        name                        definition
    t             time                        0 is clean, 1 is noise: the paper's t/T
    alpha_bar(t)  share of signal power left  product of the paper's alpha_s
    x_t           noisy layout                sqrt(alpha_bar) x_0 + sqrt(1 - alpha_bar) eps
    eps           the noise                   standard normal
    v             velocity                    sqrt(alpha_bar) eps - sqrt(1 - alpha_bar) x_0
"""
