"""Trainings of the paper's presets on the corpus and on other layouts, in turn, on a GPU.

    aeroscene dataset build
    python tools/train_presets.py --minutes 10 --out presets --layouts front3d.jsonl.gz

The minutes are shared by all trainings: two presets on each set of layouts. Batches are of 64
scenes as in the paper, and products are in bfloat16; `--compile` fuses the networks' kernels. The
same command goes on where it was stopped, and leaves alone what is finished. Where there is no GPU
it runs on the processor, which is how it is tested: `--steps 2`.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
from pathlib import Path

PRESETS = ("progressive", "paper")
_CONFIG = """\
[training]
batch_size = 64
precision = "mixed"
is_compiled = {is_compiled}
"""


def main() -> int:
    """Train each preset on each set of layouts that has not been finished.

    Returns:
        Exit status of the first training that failed, else 0.
    """
    args = _parsed()
    args.out.mkdir(parents=True, exist_ok=True)
    config = args.out / "gpu.toml"
    config.write_text(_CONFIG.format(is_compiled=str(args.compile).lower()))
    trainings = [(data, preset) for data in (args.corpus, *args.layouts) for preset in PRESETS]
    for data, preset in trainings:
        folder = args.out / f"{data.name.partition('.')[0]}-{preset}"
        if (folder / "done").exists():
            print(f"{folder}: finished before", file=sys.stderr)
            continue
        words = ["--data", str(data), "--preset", preset, "--out", str(folder)]
        words += ["--minutes", f"{args.minutes / len(trainings):.3f}", "--device", args.device]
        words += [] if args.steps is None else ["--steps", str(args.steps)]
        is_begun = (folder / "state.safetensors").exists()
        # A training that goes on has its settings in its state.
        words += ["--resume"] if is_begun else ["--config", str(config)]
        command = [sys.executable, "-m", "aeroscene", "train", *words]
        status = subprocess.run(command, check=False)  # noqa: S603 - our own command
        if status.returncode:
            return status.returncode
        # A state is there after the first save, so that it does not tell whether a training is
        # finished.
        (folder / "done").touch()
    return 0


def _parsed() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description="Train the paper's presets")
    parser.add_argument("--minutes", type=float, default=10.0, help="minutes of all (default: 10)")
    parser.add_argument("--steps", type=int, help="steps of each at most (default: no limit)")
    parser.add_argument(
        "--corpus", type=Path, default=Path("corpus"), help="dataset folder (default: corpus)"
    )
    parser.add_argument(
        "--layouts", type=Path, nargs="*", default=[], help="files of layouts besides (none)"
    )
    parser.add_argument("--device", default="auto", help="as aeroscene train takes it (auto)")
    parser.add_argument("--compile", action="store_true", help="compile the networks")
    parser.add_argument("--out", type=Path, default=Path("presets"), help="folder (presets)")
    args = parser.parse_args()
    if not 0.0 < args.minutes < float("inf"):
        parser.error(f"minutes {args.minutes} is out of range; valid: above 0")
    return args


if __name__ == "__main__":
    sys.exit(main())
