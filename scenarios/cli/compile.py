"""`aeroscene compile`: compile every kernel now, so that nothing compiles in a flight."""

from __future__ import annotations

from dataclasses import dataclass

from scenarios.cli.command_line import EXIT_DONE
from scenarios.cli.progress import share_bar


@dataclass(frozen=True, kw_only=True)
class CompileCfg:
    """Compile every kernel now and keep the machine code, so that nothing compiles in a flight.

    Takes about half a minute once, and a second or two when there is nothing to do.
    """


def run(_: CompileCfg) -> int:
    """Compile all kernels, with a progress bar."""
    from scenarios.run.kernels import compile_everything  # noqa: PLC0415 - all that compiles

    with share_bar() as on_progress:
        compile_everything(on_progress)
    return EXIT_DONE
