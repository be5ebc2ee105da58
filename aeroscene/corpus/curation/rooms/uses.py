"""Sizes and fullness of rooms by use, from public layouts as far as these have the use.

Dwellings: floor areas of 1,452 rooms of 3D-FRONT by name (10%, 50% and 90% of the rooms: master
bedrooms 10.6, 14.5, 21.1 m2; second bedrooms 8.7, 11.3, 15.3; living rooms 14, 25, 44; living and
dining in one 20, 30, 47; dining rooms 6.7, 13, 24.6), and of 100 houses of ProcTHOR, whose bedrooms
are twice as large (kitchens 17, 28, 48; bathrooms 10, 17, 30). Kitchens and bathrooms, which
3D-FRONT does not furnish, lie between a half of ProcTHOR's median and all of it.

Objects on 100 m2, pooled over each set, 3D-FRONT and ProcTHOR's houses and single rooms: bedrooms
36, 57, 80; living rooms 39 to 44, 54, 69; dining rooms 53; kitchens 81, 93; bathrooms 41. Longer
sides over shorter ones: median 1.3 to 1.6, 90% below 2.3.

Uses that no set has follow planners' rules: 8 to 10 m2 for each desk, about 2 m2 for each pupil and
each seat at a conference table, 1.5 to 2 m2 for each guest, 2 to 3 m2 for each toilet with its
share of basins and floor.
"""

from __future__ import annotations

from dataclasses import dataclass

from aeroscene.corpus.curation.draw import Draw

MOST_ASPECT = 2.2
"""Greatest ratio of a room's length to its width."""


@dataclass(frozen=True, slots=True)
class Use:
    """Size and fullness that a room's use asks for."""

    least_m2: float
    most_m2: float
    per_100_m2: float
    """Number of fine objects on 100 m2 at which it looks used."""

    def draw_area(self, draw: Draw) -> float:
        """Draw an area of a room, m2; all within the range are equally likely."""
        return draw.between(self.least_m2, self.most_m2)


USES: dict[str, Use] = {
    "bedroom": Use(11.0, 18.0, 85.0),
    "living": Use(20.0, 32.0, 68.0),
    "dining": Use(12.0, 20.0, 75.0),
    "kitchen": Use(13.0, 22.0, 90.0),
    "bathroom": Use(8.5, 13.0, 42.0),
    "washroom": Use(11.0, 19.0, 60.0),
    "office": Use(11.0, 19.0, 62.0),
    "meeting": Use(16.0, 28.0, 55.0),
    "open_office": Use(38.0, 70.0, 52.0),
    "classroom": Use(46.0, 62.0, 55.0),
    "library": Use(45.0, 90.0, 45.0),
    "workshop": Use(26.0, 50.0, 38.0),
    "store": Use(12.0, 22.0, 58.0),
    "changing": Use(16.0, 28.0, 36.0),
    "gym": Use(40.0, 80.0, 24.0),
    "cafe": Use(32.0, 64.0, 52.0),
    "restaurant": Use(45.0, 90.0, 82.0),
    "galley": Use(22.0, 38.0, 66.0),
    "ward": Use(20.0, 30.0, 62.0),
    "practice": Use(14.0, 20.0, 62.0),
    "waiting": Use(16.0, 30.0, 58.0),
    "lobby": Use(50.0, 110.0, 22.0),
    "lounge": Use(30.0, 60.0, 36.0),
    "garden": Use(40.0, 90.0, 20.0),
    "corridor": Use(10.0, 50.0, 20.0),
    "court": Use(100.0, 200.0, 16.0),
    "stand": Use(40.0, 90.0, 24.0),
    "concourse": Use(70.0, 160.0, 26.0),
    "racks": Use(70.0, 160.0, 26.0),
    "goods": Use(70.0, 160.0, 24.0),
    "storage": Use(40.0, 100.0, 30.0),
    "aisles": Use(60.0, 140.0, 42.0),
    "produce": Use(50.0, 120.0, 34.0),
    "checkout": Use(50.0, 120.0, 26.0),
    "booths": Use(60.0, 150.0, 30.0),
}
"""Every use under its name."""
