"""Files that somebody else made, in a process each: the command's answer to them, and its costs.

    python tools/fuzz_files.py                      # all kinds, half an hour on two cores
    python tools/fuzz_files.py --kind scene --kind mesh --jobs 4 --keep /tmp/hostile

A hostile file is refused in one line with status 2, or it is what the command takes it for. Neither
takes more than 300 MB and 10 s of CPU, leaves a file outside its folder, runs what a folder names,
or sends the terminal a control character. Prints a table; exit status 1 where a case breaks one of
these limits.
"""

from __future__ import annotations

import argparse
import json
import shutil
import sys
import tempfile
import threading
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path

from fuzzing.files import Case, all_cases
from fuzzing.files.judging import Outcome, judge


class Trials:
    """Cases that several threads take one after another, so that few are in memory at a time."""

    def __init__(self, cases: Iterator[Case], folder: Path, *, is_kept: bool) -> None:
        self._cases = enumerate(cases)
        self._folder = folder
        self._is_kept = is_kept
        self._lock = threading.Lock()
        self.outcomes: list[Outcome] = []

    def work(self, log: Path | None) -> None:
        """Take cases, judge them and print the outcomes, until no case is left.

        Args:
            log: File that a JSON row is appended to for each case; None writes none.
        """
        while True:
            # A generator must not be entered by two threads. The files are written here too, so
            # that one case at a time is in memory: some have tens of megabytes.
            with self._lock:
                if (found := next(self._cases, None)) is None:
                    return
                number, case = found
                folder = self._folder / f"{number:03d}-{case.kind}-{case.name}"
                words = case.write(folder)
            outcome = judge(case.kind, case.name, words, folder)
            # Deleted at once, because all of them together would fill a small disk.
            if not self._is_kept:
                shutil.rmtree(folder, ignore_errors=True)
            with self._lock:
                self.outcomes.append(outcome)
                print(outcome.line(), flush=True)
                if log is not None:
                    with log.open("a") as file:
                        file.write(json.dumps(asdict(outcome)) + "\n")


def main() -> int:
    """Try the cases of the command line.

    Returns:
        Exit status: 1 if a case breaks a limit.
    """
    parser = argparse.ArgumentParser(description="Hostile files for every command that reads any")
    parser.add_argument("--kind", action="append", help="default: every kind")
    parser.add_argument("--name", action="append", help="default: every case of it")
    parser.add_argument("--jobs", type=int, default=2, help="processes at a time")
    parser.add_argument("--keep", type=Path, help="folder in which the files stay")
    parser.add_argument("--log", type=Path, help="file that a JSON row a case is appended to")
    options = parser.parse_args()
    cases = (
        case
        for case in all_cases()
        if (options.kind is None or case.kind in options.kind)
        and (options.name is None or case.name in options.name)
    )
    with tempfile.TemporaryDirectory(prefix="aeroscene-hostile-") as temporary:
        folder = options.keep or Path(temporary)
        trials = Trials(cases, folder, is_kept=options.keep is not None)
        # Threads suffice, because each waits for a process.
        threads = [
            threading.Thread(target=trials.work, args=(options.log,)) for _ in range(options.jobs)
        ]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    _print_summary(trials.outcomes)
    return 1 if any(outcome.faults for outcome in trials.outcomes) else 0


def _print_summary(outcomes: list[Outcome]) -> None:
    heads = ("files", "refused", "taken", "most MB", "CPU s", "faults")
    print(f"{'kind':<12}" + "".join(f"{head:>9}" for head in heads))
    kinds = list(dict.fromkeys(outcome.kind for outcome in outcomes))
    for kind in (*kinds, "all"):
        of_kind = [each for each in outcomes if kind in {each.kind, "all"}]
        n_refused = sum(each.status == 2 for each in of_kind)
        figures = (
            len(of_kind),
            n_refused,
            len(of_kind) - n_refused,
            round(max(each.peak_mb for each in of_kind)),
            max(each.cpu_s for each in of_kind),
            sum(bool(each.faults) for each in of_kind),
        )
        print(f"{kind:<12}" + "".join(f"{figure:>9}" for figure in figures))


if __name__ == "__main__":
    sys.exit(main())
