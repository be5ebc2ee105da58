"""`aeroscene compile`: compile every kernel now, so that nothing compiles in a flight."""

from __future__ import annotations

from dataclasses import dataclass

from rich.console import Console
from rich.progress import Progress

from scenarios.cli.command_line import EXIT_DONE


@dataclass(frozen=True, kw_only=True)
class CompileCfg:
    """Compile every kernel now and keep the machine code, so that nothing compiles in a flight.

    Takes about half a minute once, and a second or two when there is nothing to do.
    """


def run(_: CompileCfg) -> int:
    """Compile."""
    from scenarios.run.kernels import compile_everything  # noqa: PLC0415 - all that compiles

    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("", total=1.0)
        compile_everything(
            lambda title, share: bar.update(task, description=title, completed=share)
        )
    return EXIT_DONE
