"""The commands `aeroscene-sitl` and `aeroscene`: one module a command, options as a dataclass.

Each command module has a frozen dataclass of options, whose field docstrings are the `--help`
texts, and a function `run(cfg)` that returns the exit status. Heavy libraries (MuJoCo, PyTorch,
rerun, pyarrow) are imported inside functions, so that `--help` and refusals of bad input stay fast.
"""
