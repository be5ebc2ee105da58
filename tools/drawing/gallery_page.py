"""The page that shows the gallery's pictures."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

_HEAD = """# What the scenes look like

This page shows you scenes of every kind, so that you can choose one to fly. Open scene 36 with
`aeroscene sitl 36`, and a curated one with `aeroscene sitl corpus:13`. [Scenes](scenes.md) explains
what a scene holds, and [Generate](model.md) how you make more of a kind.

The vehicle's cameras use the same renderer as these pictures. `python tools/draw_gallery.py` draws
them all anew and writes this page, and `tools/draw_scene.py` draws any other scene. Every texture
is made by seeded code in `flightsim/looks/`; none is a photograph.
"""
_SECTIONS = {
    "generated": """## Generated

These scenes of the AeroScene dataset are the model's own, both their program and their numbers.
""",
    "places": """## Places of the corpus, and generated ones beside them

The model learns from curated scenes, which `aeroscene/corpus/curation/` composes. To the right of
some you see a scene of the same kind that the model made. These are fine pictures: each pixel is
lit by rays to the sun and the sky, so that shadows are soft and corners dark.
""",
    "onboard": """## On board

This is what your pilot gets from the vehicle's cameras at 320 x 240, without a graphics card and in
about ten milliseconds: forward in colour and depth, then down. Shadows, shade and lamps are painted
into the skins, so that they cost nothing when a frame is drawn. Depth is shown in colours from the
nearest (red) to the farthest (blue).
""",
    "areas": """## Landing and perching areas

Landing areas are blue for small, green for medium and orange for large drones. Perching areas are
violet.
""",
    "categories": """## The 70 categories

You see three objects of each category: a small, a medium and a large one, within the range of the
catalogue. Forms and colours vary with the object's number and its attributes.
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
