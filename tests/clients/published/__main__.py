"""Run the published examples of MAVSDK-Python, each against a fresh testbench, and print a table.

    git clone https://github.com/mavlink/MAVSDK-Python
    python -m tests.clients.published MAVSDK-Python/examples       # all of them, some minutes
    python -m tests.clients.published MAVSDK-Python/examples --only goto,mission
    python -m tests.clients.published MAVSDK-Python/examples --python OTHER/bin/python --json

Nothing of them is edited but the address, the server's port, the name of the package where it
has been renamed, and what the row of an example says. The exit status is 1 where one does not end
as the table says that it should, and 2 where an example or the folder of them is not there.
"""

from __future__ import annotations

import argparse
import json
import re
import sys
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from itertools import chain
from pathlib import Path
from queue import SimpleQueue
from typing import Any

from tests.clients.published.examples import EXAMPLES, NOT_RUN, Example
from tests.clients.published.running import Outcome, Runner
from tests.instances import new_instance


def main() -> int:
    """Run what is asked for; returns the exit status."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("examples", type=Path, help="folder of the examples")
    options.add_argument("--only", default="", help="names, with commas between (default: all)")
    options.add_argument("--jobs", type=int, default=1, help="examples at a time")
    options.add_argument("--python", default=sys.executable, help="interpreter that has MAVSDK")
    options.add_argument(
        "--json", action="store_true", help="print one JSON object, and the table to standard error"
    )
    chosen = options.parse_args()
    names = chosen.only.split(",") if chosen.only else list(EXAMPLES)
    for name in names:
        if name not in EXAMPLES:
            options.error(f"--only {name}: no such example; valid: {', '.join(EXAMPLES)}")
        if not EXAMPLES[name].path(chosen.examples).is_file():
            options.error(f"{EXAMPLES[name].path(chosen.examples)} is not there")
    rows = []
    not_run = () if chosen.only else map(_row_of_none, NOT_RUN)
    for row in chain(_rows([EXAMPLES[name] for name in names], chosen), not_run):
        rows.append(row)
        seconds = f"{row['seconds']:6.1f} s" if "seconds" in row else ""
        line = f"{row['example']:32} {row['ends']:16} {seconds:>8}  {row['note']}"
        print(line, file=sys.stderr if chosen.json else sys.stdout, flush=True)
    if chosen.json:
        print(json.dumps({"rows": rows}))
    return 0 if all(row.get("is_expected", True) for row in rows) else 1


def _rows(examples: Sequence[Example], chosen: argparse.Namespace) -> Iterator[Mapping[str, Any]]:
    """Run the examples, so many at a time, and tell of each in their order."""
    runners: SimpleQueue[Runner] = SimpleQueue()

    def run(example: Example) -> Outcome:
        runner = runners.get()
        try:
            return runner.run(example)
        finally:
            runners.put(runner)

    with ExitStack() as stack:
        for _ in range(chosen.jobs):
            runner = Runner(chosen.examples, new_instance(), chosen.python)
            stack.callback(runner.close)
            runners.put(runner)
        pool = stack.enter_context(ThreadPoolExecutor(chosen.jobs))
        for example, outcome in zip(examples, pool.map(run, examples), strict=True):
            yield _row(example, outcome)


def _row(example: Example, outcome: Outcome) -> Mapping[str, Any]:
    is_raised = re.search(example.raises, outcome.output) is not None
    is_expected = outcome.finishes == (example.but is None) and is_raised
    edited = [f"{there} is {here}" for there, here in example.edits.items()]
    says = outcome.note if is_expected and example.but is None else example.but or outcome.note
    return {
        "example": example.name,
        "ends": "finishes" if outcome.finishes else "does not finish",
        "is_expected": is_expected,
        "seconds": round(outcome.seconds, 1),
        "note": "; ".join([*edited, says]),
    }


def _row_of_none(name: str) -> Mapping[str, Any]:
    return {"example": name, "ends": "not run", "note": NOT_RUN[name]}


if __name__ == "__main__":
    sys.exit(main())
