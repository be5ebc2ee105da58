"""The page that shows the gallery's pictures."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

_HEAD = """# What do the scenes look like?

Pictures by the renderer that the cameras use. `python tools/draw_gallery.py` draws them all anew
and writes this page; `tools/draw_scene.py` draws any other scene. Every texture is made by seeded
code in `flightsim/looks/`, none is a photograph.
"""
_SECTIONS = {
    "generated": """## Generated

Scenes of the AeroScene dataset: program and numbers are the model's.
""",
    "places": """## Places of the corpus, and generated ones beside them

Curated scenes are what the model learns from, as they come out of `aeroscene/corpus/curation/`; on
the right of some, a scene of the kind that the model made. Fine pictures: each pixel is lit by rays
to the sun and the sky, so shadows are soft and corners dark.
""",
    "onboard": """## On board

What a camera of the vehicle gives at 320 x 240, without a graphics card and in some ten
milliseconds: forward in colour and depth, then down. Shadows, shade and lamps are in the skins, so
they cost nothing when a frame is drawn; depth is in colours from the nearest (red) to the farthest
(blue).
""",
    "areas": """## Landing and perching areas

Landing areas for small (blue), medium (green) and large drones (orange), perching areas in violet.
""",
    "categories": """## The 70 categories

Three of each, small, middling and large in the range of the catalogue; forms and colours vary with
the object's number and its attributes.
""",
}


@dataclass(frozen=True)
class Shown:
    """A picture of the gallery, with what the page says of it."""

    section: str
    file: str
    title: str
    text: str
    scene: str | None
    """Scene of the picture, as `--scene` takes it; None for a picture of several."""
    beside: str | None = None
    """File of a generated scene of the same kind, shown on the right; None for a picture alone."""
    beside_scene: str | None = None


def write_page(page: Path, folder: Path, shown: list[Shown]) -> None:
    """Write the page, section by section; its links to pictures are relative to it.

    Args:
        page: File to write.
        folder: Folder that has the pictures.
        shown: Pictures of all sections, in the order in which each section shows them.
    """
    where = os.path.relpath(folder, page.parent)
    parts = [_HEAD]
    for section, intro in _SECTIONS.items():
        parts.append(intro)
        parts += [_entry(item, where) for item in shown if item.section == section]
    page.write_text("\n".join(parts), encoding="utf-8")


def _entry(item: Shown, where: str) -> str:
    title = f"**{item.title}**" + (f" (scene {item.scene})" if item.scene else "")
    text = f"{title}. {item.text}".rstrip()
    if item.beside is None:
        return f"{text}\n\n![{item.title}]({where}/{item.file})\n"
    head = f"| curated | generated (scene {item.beside_scene}) |\n|---|---|"
    curated = f"![{item.title}]({where}/{item.file})"
    generated = f"![{item.title}, generated]({where}/{item.beside})"
    return f"{text}\n\n{head}\n| {curated} | {generated} |\n"
