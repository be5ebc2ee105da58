"""Small places of which one sees at once what stands how."""

from tests.aeroscene.metrics.scenes import box, scene_of

ROOM = ("room", box((0, 0, 1.5), (12, 10, 3)))


def on_floor(category, x, y, size, yaw_deg=0.0, parent=0):
    return category, box((x, y, size[2] / 2), size, yaw_deg), parent


def dining(turned_deg=0.0, shift_m=0.0):
    """A table with two chairs on each long side; two of them may be turned or moved off."""
    table = on_floor("table", 1.0, 0.5, (0.9, 1.8, 0.74))
    chairs = [
        on_floor(
            "chair",
            1.0 + side * (0.45 + 0.25 + 0.08) + (shift_m if side > 0 else 0.0),
            0.5 + along,
            (0.5, 0.5, 0.9),
            (180.0 if side > 0 else 0.0) + (turned_deg if side > 0 else 0.0),
        )
        for side in (-1, 1)
        for along in (-0.45, 0.45)
    ]
    return scene_of(ROOM, table, *chairs)


def office(off_m=(), hole=None):
    """Desks in two rows of four, 1.8 m apart; some moved along, one left out."""
    desks = [
        on_floor("desk", 2.0 * row - 1.0, 1.8 * column - 2.7, (0.8, 1.4, 0.74))
        for row in range(2)
        for column in range(4)
        if (row, column) != hole
    ]
    for index, shift_m in enumerate(off_m):
        name, bbox, parent = desks[index]
        desks[index] = (name, box((bbox.p[0], bbox.p[1] + shift_m, bbox.p[2]), bbox.s), parent)
    return scene_of(ROOM, *desks)


def street(*things):
    """A road along x, 8 m wide, with a pavement north of it."""
    road = ("road", box((0, 0, 0.05), (60, 8, 0.1)))
    walk = ("sidewalk", box((0, 5.5, 0.075), (60, 3, 0.15)))
    return scene_of(road, walk, *things)
