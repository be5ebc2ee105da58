"""`aeroscene compile`: compile every kernel now, so that nothing compiles when it is needed."""

from __future__ import annotations

from dataclasses import dataclass

from scenarios.cli.command_line import EXIT_DONE
from scenarios.cli.progress import share_bar


@dataclass(frozen=True, kw_only=True)
class CompileCfg:
    """Compile every kernel now, of flights and of the scene model, and keep the machine code.

    Takes about a minute once, and some seconds when there is nothing to do.
    """


def run(_: CompileCfg) -> int:
    """Compile all kernels, with a progress bar."""
    from scenarios.run.kernels import compile_everything

    with share_bar() as on_progress:
        compile_everything(on_progress)
    return EXIT_DONE
