"""Results of all vehicles of a run, which `--json` prints."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from typing import Any

from scenarios.trials.result import TrialResult


@dataclass(frozen=True, kw_only=True, slots=True)
class RunResult:
    """Results of all vehicles of a run, the first one first."""

    first_system: int
    """MAVLink system id of the first vehicle; the ids of the others follow."""
    vehicles: tuple[TrialResult, ...]

    @property
    def success(self) -> bool | None:
        """True if all flights are done; None if nobody flew."""
        # A vehicle without a pilot leaves the run without a verdict.
        said = [result.success for result in self.vehicles]
        return None if None in said else all(said)

    @property
    def reason(self) -> str:
        """End of each flight, in words."""
        return "; ".join(f"vehicle {i + 1}: {r.reason}" for i, r in enumerate(self.vehicles))

    @property
    def state_hash(self) -> str:
        """Hash of every state of all flights."""
        hashes = "".join(result.state_hash for result in self.vehicles)
        return hashlib.blake2b(hashes.encode(), digest_size=16).hexdigest()

    def to_plain(self) -> dict[str, Any]:
        """The results as plain data: of one vehicle alone, or of the run and of each vehicle."""
        first = self.vehicles[0].to_plain()
        if len(self.vehicles) == 1:
            return first
        # Fields that are the same for all vehicles stand once, beside the list of vehicles.
        of_run = ("scene", "seed", "sim_seconds", "wall_seconds", "cpu_seconds")
        return {
            "success": self.success,
            "reason": self.reason,
            **{name: first[name] for name in (*of_run, "real_time_factor", "recording")},
            "state_hash": self.state_hash,
            "vehicles": [
                {"system": self.first_system + i, **result.to_plain()}
                for i, result in enumerate(self.vehicles)
            ],
        }
