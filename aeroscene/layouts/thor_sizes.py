"""Sizes of AI2-THOR's types of objects, which houses of ProcTHOR do not state.

A house names assets; the size of each is in ProcTHOR's `asset-database.json`. Here is the median of
every type over its assets there, for houses without that file beside them.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache

from aeroscene.scene import Vector3

# Type; width, depth and height in m. A side below 1 cm counts as 1 cm.
# Source: allenai/procthor, procthor/databases/asset-database.json, 1,653 assets.
_SIZES = """
AlarmClock 0.19 0.09 0.18; AluminumFoil 0.24 0.06 0.04; Apple 0.1 0.1 0.12; ArmChair 0.94 0.89
0.88; BaseballBat 0.08 0.09 0.96; BasketBall 0.24 0.24 0.24; Bed 1.37 2.24 0.91; Blinds 1.1 0.03
0.2; Book 0.22 0.27 0.03; Boots 0.28 0.22 0.52; Bottle 0.11 0.11 0.25; Bowl 0.2 0.2 0.09; Box
0.4 0.41 0.28; Bread 0.16 0.29 0.14; ButterKnife 0.01 0.26 0.03; CD 0.1 0.1 0.01; Candle 0.05
0.05 0.17; Cart 0.71 0.54 1.28; CellPhone 0.08 0.15 0.01; Chair 0.48 0.54 0.88; Cloth 0.21 0.18
0.02; ClothesDryer 0.68 0.69 1.05; CoffeeMachine 0.44 0.44 0.44; CoffeeTable 1.13 0.66 0.44;
CounterTop 2.44 1.83 0.94; CreditCard 0.09 0.05 0.01; Cup 0.11 0.11 0.15; Desk 1.39 0.62 0.79;
DeskLamp 0.26 0.29 0.46; Desktop 0.88 0.25 0.57; DiningTable 1.47 0.96 0.76; DishSponge 0.07
0.14 0.03; DogBed 0.99 0.83 0.18; Dresser 1.2 0.51 0.97; Dumbbell 0.13 0.33 0.13; Egg 0.05 0.05
0.08; Faucet 0.27 0.25 0.22; FloorLamp 0.52 0.51 1.87; Footstool 0.32 0.28 0.43; Fork 0.03 0.23
0.03; Fridge 1 0.72 1.84; GarbageBag 0.51 0.52 0.56; GarbageCan 0.45 0.37 0.56; HandTowel 0.13
0.04 0.4; HandTowelHolder 0.17 0.05 0.21; HousePlant 0.36 0.39 0.65; Kettle 0.2 0.21 0.19;
KeyChain 0.13 0.07 0.01; Knife 0.01 0.33 0.05; Ladle 0.08 0.29 0.05; Laptop 0.4 0.3 0.29;
LaundryHamper 0.55 0.43 0.74; Lettuce 0.15 0.24 0.15; LightSwitch 0.13 0.03 0.15; Microwave 0.61
0.36 0.35; Mug 0.13 0.09 0.1; Newspaper 0.33 0.13 0.03; Ottoman 0.85 0.52 0.43; Painting 0.81
0.03 0.61; Pan 0.28 0.43 0.05; PaperTowelRoll 0.08 0.06 0.21; Pen 0.01 0.2 0.01; Pencil 0.01
0.18 0.01; PepperShaker 0.07 0.07 0.11; Pillow 0.43 0.35 0.14; Plate 0.24 0.24 0.02; Plunger
0.15 0.15 0.54; Pot 0.29 0.31 0.16; Potato 0.08 0.12 0.08; RemoteControl 0.06 0.21 0.02;
RoomDecor 0.3 0.37 1.34; Safe 0.4 0.45 0.4; SaltShaker 0.07 0.07 0.11; ScrubBrush 0.13 0.13
0.48; ShelvingUnit 0.91 0.34 1.44; ShowerCurtain 0.34 0.33 1.66; ShowerHead 0.23 0.25 1.41;
SideTable 0.62 0.39 0.66; Sink 0.66 0.46 0.15; SoapBar 0.05 0.09 0.02; SoapBottle 0.12 0.1 0.24;
Sofa 2.4 0.93 0.92; Spatula 0.06 0.3 0.02; Spoon 0.04 0.21 0.02; SprayBottle 0.03 0.11 0.25;
Statue 0.19 0.15 0.35; Stool 0.41 0.32 0.67; TVStand 1.2 0.6 0.71; TableTopDecor 0.4 0.31 0.14;
TeddyBear 0.47 0.33 0.47; Television 1.14 0.31 0.81; TennisRacket 0.26 0.65 0.04; TissueBox 0.2
0.1 0.15; Toaster 0.22 0.36 0.21; Toilet 0.53 0.92 0.99; ToiletPaper 0.07 0.07 0.12;
ToiletPaperHanger 0.23 0.1 0.08; Tomato 0.12 0.13 0.1; Towel 0.41 0.04 0.59; TowelHolder 0.66
0.11 0.04; VacuumCleaner 0.36 0.31 1.01; Vase 0.18 0.17 0.21; WashingMachine 0.68 0.69 1.05;
Watch 0.08 0.05 0.04; WateringCan 0.15 0.27 0.19; WineBottle 0.09 0.09 0.33
"""


@cache
def typical_sizes_m() -> Mapping[str, Vector3]:
    """Median width, depth and height (m) of the assets of each type."""
    sizes: dict[str, Vector3] = {}
    for entry in " ".join(_SIZES.split()).split("; "):
        name, x, y, z = entry.split()
        sizes[name] = (float(x), float(y), float(z))
    return sizes
