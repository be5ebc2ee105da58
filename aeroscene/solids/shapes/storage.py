"""Cases with doors and boards: cabinets, wardrobes, shelves, kitchen appliances; front is +x."""

from __future__ import annotations

from aeroscene.solids.shapes.forms import FORMS
from aeroscene.solids.shapes.furniture import WOODS
from aeroscene.solids.shapes.look import Look
from aeroscene.solids.shapes.materials import FABRIC_COLOURS, PAINT_COLOURS
from aeroscene.solids.shapes.primitive import Interval, Part, block, centred
from aeroscene.solids.shapes.solids import about, disc, inwards, legs, paint

_DOOR_M = 0.02


def _case(look: Look, low: float, material: str) -> tuple[Part, Interval]:
    """A solid case above `low`, and the interval in front of it for doors."""
    x, y, z = look.size_m
    front = inwards(1, x / 2, _DOOR_M)
    return block((-x / 2, front[0]), y, (low, z), material), front


def _grid(front: Interval, y: float, z: Interval, count: tuple[int, int], name: str) -> list[Part]:
    """Doors or drawers in columns and rows (`count`), with joints between them."""
    wide, high = y / count[0], (z[1] - z[0]) / count[1]
    return [
        paint(
            front,
            about(-y / 2 + (column + 0.5) * wide, wide - 0.03),
            about(z[0] + (row + 0.5) * high, high - 0.03),
            name,
        )
        for column in range(count[0])
        for row in range(count[1])
    ]


def cabinet(look: Look) -> list[Part]:
    """A chest with doors, with drawers, or a sideboard on legs.

    Reads the attributes `form` and `wood`.
    """
    x, y, z = look.size_m
    form, wood = look.set_choice("form", FORMS["cabinet"]), look.set_choice("wood", WOODS)
    # Doors contrast with the case.
    pane = "pale_wood" if wood != "pale_wood" else "plastic_white"
    if form == "sideboard":
        case, front = _case(look, 0.2, wood)
        doors = _grid(front, y, (0.2, z - 0.03), (3 if y > 1.2 else 2, 1), pane)
        return [case, *doors, *legs(x - 0.08, y - 0.1, (0, 0.2), 0.05, "dark_metal")]
    case, front = _case(look, 0.0, wood)
    knob = paint(front, 0.14, about(0.62 * z, 0.03), "dark_metal")
    if form == "drawers":
        return [case, *_grid(front, y, (0.06, z - 0.02), (1 if y < 1.1 else 2, 3), pane), knob]
    return [case, *_grid(front, y, (0.06, z - 0.02), (2, 1), pane), knob]


def wardrobe(look: Look) -> list[Part]:
    """A tall case with doors, with a sliding mirror, or open with clothes on a rail.

    Reads the attributes `form`, `wood` and `doors`.
    """
    _, y, z = look.size_m
    form, wood = look.choice("form", FORMS["wardrobe"]), look.choice("wood", WOODS)
    if form == "open":
        return _open_wardrobe(look, wood)
    case, front = _case(look, 0.0, wood)
    pane = look.choice("doors", ("plastic_white", "pale_wood"))
    if form == "mirror":
        half = [(-y / 2 + 0.02, -0.01), (0.01, y / 2 - 0.02)]
        return [
            case,
            paint(front, half[0], (0.05, z - 0.04), pane),
            paint(front, half[1], (0.05, z - 0.04), "glass"),
        ]
    return [case, *_grid(front, y, (0.05, z - 0.02), (max(2, round(y / 0.6)), 1), pane)]


def _open_wardrobe(look: Look, wood: str) -> list[Part]:
    x, y, z = look.size_m
    rail = 0.82 * z
    clothes = [
        paint(
            0.7 * x,
            about((index - 1) * 0.28 * y, 0.2 * y),
            (0.4 * z, rail),
            # Colours follow from the object, and differ from one piece to the next.
            f"fabric_{FABRIC_COLOURS[(look.variant + index) % len(FABRIC_COLOURS)]}",
        )
        for index in range(3)
    ]
    return [
        *(block(x, inwards(sign, y / 2, 0.03), (0, z), wood) for sign in (-1, 1)),
        block(inwards(-1, x / 2, 0.02), y - 0.06, (0, z), wood),
        block(x, y - 0.06, (z - 0.03, z), wood),
        block(x, y - 0.06, (0.06, 0.3), wood),
        disc((0, 0, rail), 0.03, y - 0.06, "metal", axis="y"),
        *clothes,
    ]


def shelf_boards(height_m: float) -> tuple[float, ...]:
    """Heights of the upper faces of an open shelf's or a bookcase's boards, from the lowest, m.

    Generators place objects on the boards by these heights.
    """
    # A board every 42 cm or so, within bounds.
    levels = max(2, min(5, round(height_m / 0.42)))
    rise = (height_m - 0.05) / levels
    return tuple(0.045 + level * rise for level in range(levels))


def shelf(look: Look) -> list[Part]:
    """Boards between two sides, a rack of steel with cartons, or a bookcase with a back.

    Reads the attributes `form`, `wood` and, of a rack, `posts`.
    """
    x, y, z = look.size_m
    form = look.set_choice("form", FORMS["shelf"])
    if form == "rack":
        return _rack(look)
    wood = look.set_choice("wood", WOODS)
    boards = shelf_boards(z)
    rise = (z - 0.05) / len(boards)
    inner = centred(y - 0.06)
    parts = [block(x, inwards(sign, y / 2, 0.03), (0, z), wood) for sign in (-1, 1)]
    parts.append(block(x, inner, (z - 0.03, z), wood))
    parts += [
        block(x, inner, (0.02 + i * rise, 0.045 + i * rise), wood) for i in range(len(boards))
    ]
    if form == "bookcase":
        parts.append(block(inwards(-1, x / 2, 0.015), inner, (0, z), wood))
    return parts + _books(look, len(boards), rise, form)


def _books(look: Look, levels: int, rise: float, form: str) -> list[Part]:
    """A row of books on each level of a bookcase, on every other level of an open shelf."""
    x, y, _ = look.size_m
    parts: list[Part] = []
    for level in range(0, levels, 1 if form == "bookcase" else 2):
        # A share of 4/9 to 8/9 of the width, which looks random but follows from level and object.
        share = ((level * 37 + look.variant * 13) % 5 + 4) / 9
        start = -y / 2 + 0.04
        low = 0.045 + level * rise
        colour = FABRIC_COLOURS[(level + look.variant) % len(FABRIC_COLOURS)]
        parts.append(
            paint(
                (-x / 2 + 0.02, 0.3 * x),
                (start, start + share * (y - 0.1)),
                (low, low + 0.68 * rise),
                f"fabric_{colour}",
            )
        )
    return parts


def _rack(look: Look) -> list[Part]:
    """Four posts, a deck every 0.8 m or so, cartons on all but the highest."""
    x, y, z = look.size_m
    levels = max(3, min(5, round(z / 0.8)))
    rise = (z - 0.1) / (levels - 1)
    decks = [0.06 + index * rise for index in range(levels)]
    colour = look.choice("posts", ("paint_blue", "paint_orange", "dark_metal"))
    parts = legs(x, y, (0, z), min(0.06, 0.2 * x), colour)
    parts += [block(x - 0.02, y - 0.02, (at, at + 0.04), "metal") for at in decks]
    for index, at in enumerate(decks[:-1]):
        # A share of 4/8 to 7/8, which looks random but follows from level and object.
        share = ((index * 29 + look.variant * 7) % 4 + 4) / 8
        wide = share * (y - 0.2)
        # Cartons stand at the left or right end in turn.
        side = (1 if (index + look.variant) % 2 else -1) * (y - 0.2 - wide) / 2
        carton = (at + 0.04, at + 0.04 + 0.62 * (rise - 0.04))
        parts.append(block(0.8 * x, about(side, wide), carton, "cardboard"))
    return parts


def fridge(look: Look) -> list[Part]:
    """A tall case with a freezer above, with two doors side by side, or a coloured retro one.

    Reads the attributes `form` and, of a retro one, `colour`.
    """
    x, y, z = look.size_m
    form = look.choice("form", FORMS["fridge"])
    if form == "retro":
        colour = "paint_" + look.choice("colour", PAINT_COLOURS)
        case, front = _case(look, 0.06, colour)
        return [
            case,
            paint(front, y - 0.04, (0.12, z - 0.05), colour),
            paint(front, inwards(-1, 0.42 * y, 0.04), about(0.6 * z, 0.3), "metal"),
            paint(x - 0.1, y - 0.06, (0, 0.06), "dark_metal"),
        ]
    case, front = _case(look, 0.0, "metal")
    if form == "double":
        handles = [
            paint((front[0], x / 2 + 0.01), about(side, 0.02), about(0.6 * z, 0.5), "dark_metal")
            for side in (-0.05, 0.05)
        ]
        return [case, *_grid(front, y, (0.02, z), (2, 1), "metal"), *handles]
    handle = paint(
        (front[0], x / 2 + 0.01), inwards(1, 0.46 * y, 0.03), about(0.5 * z, 0.3), "metal"
    )
    doors = [(0.03, 0.64 * z), (0.66 * z, z - 0.02)]
    return [case, *(paint(front, y - 0.02, door, "plastic_white") for door in doors), handle]


def stove(look: Look) -> list[Part]:
    """An oven under four plates, a wide range with two ovens, or a flat hob of glass.

    Reads the attribute `form`.
    """
    x, y, z = look.size_m
    form = look.choice("form", FORMS["stove"])
    # The form decides on the material, so that no attribute is needed.
    material = {"plates": "plastic_white", "range": "dark_metal", "island": "metal"}[form]
    case, front = _case(look, 0.0, material)
    window = (0.22 * z, 0.7 * z)
    top = (z, z + 0.006)
    if form == "island":
        hob = paint(0.84 * x, 0.86 * y, top, "plastic_black")
        return [case, hob, paint(front, 0.84 * y, window, "dark_glass")]
    plates = [
        disc((u * x, v * y, z + 0.004), 0.3 * min(x, y), 0.008, "plastic_black")
        for u in (-0.22, 0.22)
        for v in (-0.24, 0.24)
    ]
    panes = (2, 1) if form == "range" else (1, 1)
    knobs = paint((front[0], x / 2 + 0.01), 0.8 * y, about(0.84 * z, 0.04), "dark_metal")
    return [case, *plates, *_grid(front, 0.86 * y, window, panes, "dark_glass"), knobs]
