"""Districts of `aeroscene generate`: requests that the grammar meets, without the scene model."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import MISSING, fields
from typing import TYPE_CHECKING

from scenarios.cli.command_line import EXIT_DONE, EXIT_NEGATIVE
from scenarios.cli.generate_words import print_generated
from scenarios.cli.progress import progress_bar
from scenarios.generation.districts import (
    district_request,
    is_district,
    make_districts,
    require_alone,
)
from scenarios.generation.text_options import GenerateError, asked_areas, outline_sides_m

if TYPE_CHECKING:
    from aeroscene.corpus.districts.request import DistrictRequest
    from scenarios.cli.generate_cfg import GenerateCfg

_OURS = {"seed", "count", "objects", "houses", "storeys", "areas", "outline", "out", "json"}
"""Options that a district follows."""


def district_requests(cfg: GenerateCfg) -> list[DistrictRequest] | None:
    """Return requests for districts, without loading anything heavy.

    Args:
        cfg: Options of the command.

    Returns:
        One request for each seed, or None if the options ask for the scene model instead.

    Raises:
        SceneError: If a district cannot be made, or an option stands beside it that it cannot
            follow.
    """
    outline_m = outline_sides_m(cfg.outline) if cfg.outline else None
    if not is_district(outline_m, cfg.objects, cfg.houses, cfg.storeys):
        return None
    # A field without a plain default has nothing to compare with.
    require_alone(
        {
            field.name.replace("_", "-"): (getattr(cfg, field.name), field.default)
            for field in fields(cfg)
            if field.name not in _OURS and field.default is not MISSING
        }
    )
    areas = asked_areas(cfg.areas) if cfg.areas else None
    if areas is not None and not isinstance(areas, int):
        raise GenerateError(
            f"areas is {cfg.areas!r} beside a district; valid: one number, of all classes together"
        )
    return [
        district_request(
            seed,
            outline_m=outline_m,
            n_objects=cfg.objects,
            n_houses=cfg.houses,
            n_storeys=cfg.storeys,
            n_areas=areas,
        )
        for seed in range(cfg.seed, cfg.seed + cfg.count)
    ]


def run_districts(cfg: GenerateCfg, requests: Sequence[DistrictRequest]) -> int:
    """Compose districts, write them, and print what was made.

    Args:
        cfg: Options of the command.
        requests: One request for each seed.

    Returns:
        0, or 1 if a seed gave no district.
    """
    from scenarios.generation.draws import Tally

    cfg.out.mkdir(parents=True, exist_ok=True)
    tally = Tally(cfg.out)
    with progress_bar("composing", len(requests)) as advance:
        make_districts(requests, tally, advance)
    print_generated(cfg.out, "cpu", tally, {}, as_json=cfg.json)
    return EXIT_NEGATIVE if tally.failed else EXIT_DONE
