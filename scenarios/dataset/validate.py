"""Checks of every scene of a dataset against the rules of scenes, in parallel."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any, get_args

from aeroscene.corpus.summary import Entry, SceneSet
from aeroscene.processes import run_all
from aeroscene.scene import SceneError
from aeroscene.validation import Finding, FindingKind, validate

KINDS: tuple[FindingKind, ...] = get_args(FindingKind)
"""Kinds of findings, in the order of the report."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Report:
    """Results of the checks."""

    readable: SceneSet[Any]
    """Scenes that could be read."""
    findings: tuple[Finding, ...]
    invalid: tuple[str, ...]
    """One line for each scene that could not be read."""

    @property
    def n_scenes(self) -> int:
        """Number of scenes checked."""
        return len(self.readable.entries)

    def counts(self) -> dict[str, int]:
        """Return the number of findings of each kind, with 0 for kinds without any."""
        counts = Counter(finding.kind for finding in self.findings)
        return {kind: counts[kind] for kind in KINDS}

    def to_plain(self) -> dict[str, Any]:
        """Return the report as plain data.

        Keys are scenes, findings by kind, details with every finding in full, and invalid.
        """
        return {
            "scenes": self.n_scenes,
            "findings": self.counts(),
            "details": [asdict(finding) for finding in self.findings],
            "invalid": list(self.invalid),
        }


def validate_all(
    dataset: SceneSet[Entry], jobs: int, on_scene: Callable[[], None], *, skip_invalid: bool
) -> Report:
    """Read and check every scene.

    Args:
        dataset: Scenes to check.
        jobs: Number of processes.
        on_scene: Called after each scene.
        skip_invalid: True continues after a scene that cannot be read.

    Raises:
        SceneError: At the first scene that cannot be read, unless it is to be skipped.
    """
    findings: list[Finding] = []
    invalid: list[str] = []
    readable: set[int] = set()
    check = partial(_check, dataset.select(()))
    with closing(run_all(check, dataset.entries, jobs)) as results:
        for entry, found in zip(dataset.entries, results, strict=True):
            on_scene()
            # Results come in the order of the entries, whichever process was faster.
            if not isinstance(found, SceneError):
                findings += found
                readable.add(entry.index)
            elif skip_invalid:
                invalid.append(str(found))
            else:
                raise found
    return Report(
        readable=dataset.select(readable), findings=tuple(findings), invalid=tuple(invalid)
    )


def _check(reader: SceneSet[Entry], entry: Entry) -> tuple[Finding, ...] | SceneError:
    try:
        scene = reader.read(entry)
    # Returned rather than raised, so that the other scenes are still checked.
    except SceneError as error:
        return error
    return validate(scene)


def first_of_each_kind(findings: tuple[Finding, ...], count: int) -> Iterator[Finding]:
    """Yield the first findings of each kind, as examples.

    Args:
        findings: All findings.
        count: Greatest number of each kind.
    """
    for kind in KINDS:
        yield from [finding for finding in findings if finding.kind == kind][:count]
