"""Run the published examples of MAVSDK-Python, each against a fresh testbench, and print a table.

    git clone https://github.com/mavlink/MAVSDK-Python
    python -m tests.clients.published MAVSDK-Python/examples       # all of them, some minutes
    python -m tests.clients.published MAVSDK-Python/examples --only goto,mission
    python -m tests.clients.published MAVSDK-Python/examples --python OTHER/bin/python

Nothing of them is edited but the address, the server's port, and the name of the package where it
has been renamed. The exit status is 1 where one does not end as the table says that it should.
"""

from __future__ import annotations

import argparse
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from queue import SimpleQueue

from tests.clients.published.running import EXAMPLES, Example, Outcome, Runner
from tests.instances import new_instance


def main() -> int:
    """Run what is asked for; returns the exit status."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("examples", type=Path, help="folder of the examples")
    options.add_argument("--only", default=",".join(EXAMPLES), help="names, with commas between")
    options.add_argument("--jobs", type=int, default=1, help="examples at a time")
    options.add_argument("--python", default=sys.executable, help="interpreter that has MAVSDK")
    chosen = options.parse_args()
    runners: SimpleQueue[Runner] = SimpleQueue()
    for _ in range(chosen.jobs):
        runners.put(Runner(chosen.examples, new_instance(), chosen.python))

    def run(example: Example) -> Outcome:
        runner = runners.get()
        try:
            return runner.run(example)
        finally:
            runners.put(runner)

    n_others = 0
    with ThreadPoolExecutor(chosen.jobs) as pool:
        examples = [EXAMPLES[name] for name in chosen.only.split(",")]
        for example, outcome in zip(examples, pool.map(run, examples), strict=True):
            is_told = outcome.finishes == (example.but is None)
            n_others += not is_told
            word = "finishes" if outcome.finishes else "does not finish"
            note = outcome.note if is_told and example.but is None else example.but or outcome.note
            print(f"{example.name:32} {word:16} {outcome.seconds:6.1f} s  {note}", flush=True)
    for _ in range(chosen.jobs):
        runners.get().close()
    return 1 if n_others else 0


if __name__ == "__main__":
    sys.exit(main())
