"""Names of other sources under our name for the same object or, failing that, a similar one.

`SAME` holds names of exactly that object. `STAND_INS` holds names for which none of our 70
categories is right: the nearest in form and size stands in, so that an obstacle stays an obstacle.
Names are those of the 3D-FUTURE catalogue (3D-FRONT), of ProcTHOR's asset types, and ours.
"""

from __future__ import annotations

from collections.abc import Mapping


def _names(text: str) -> tuple[str, ...]:
    return tuple(text.split(", "))


SAME: Mapping[str, tuple[str, ...]] = {
    "table": ("Dining Table", "DiningTable"),
    "chair": _names(
        "Dining Chair, Dressing Chair, Classic Chinese Chair, Folding chair, "
        "Lounge Chair / Book-chair / Computer Chair, Chair"
    ),
    "sofa": _names(
        "Three-Seat / Multi-seat Sofa, Three-Seat / Multi-person sofa, Two-seat Sofa, "
        "Loveseat Sofa, L-shaped Sofa, U-shaped Sofa, Chaise Longue Sofa, Sofa"
    ),
    "armchair": _names("armchair, Lounge Chair / Cafe Chair / Office Chair, Lazy Sofa, ArmChair"),
    "bed": _names("King-size Bed, Double Bed, Single bed, Kids Bed, Bunk Bed, Bed Frame, Bed"),
    "desk": ("Desk",),
    "cabinet": _names(
        "TV Stand, Sideboard / Side Cabinet / Console Table, Sideboard / Side Cabinet / Console, "
        "Drawer Chest / Corner cabinet, Children Cabinet, Shoe Cabinet, Dresser, TVStand"
    ),
    "wardrobe": ("Wardrobe",),
    "shelf": ("Bookcase / jewelry Armoire", "Shelf", "ShelvingUnit"),
    "coffee_table": _names(
        "Coffee Table, Tea Table, Corner/Side Table, Round End Table, CoffeeTable, SideTable"
    ),
    "nightstand": ("Nightstand",),
    "counter": ("Bar", "CounterTop"),
    "fridge": ("Fridge",),
    "television": ("Television",),
    "lamp": _names("Pendant Lamp, Ceiling Lamp, Floor Lamp, Wall Lamp, FloorLamp, DeskLamp"),
    "plant": ("HousePlant",),
    "laptop": ("Laptop",),
    "monitor": ("Desktop",),
    "plate": ("Plate",),
    "cup": ("Cup", "Mug"),
    "book": ("Book", "Newspaper"),
    "box": ("Box",),
    "bin": ("GarbageCan",),
    "toilet": ("Toilet",),
    "basin": ("Sink",),
    "bath": ("Bathtub",),
    "building": ("building",),
}

STAND_INS: Mapping[str, tuple[str, ...]] = {
    # Seats without a back.
    "chair": ("Barstool", "Stool"),
    "coffee_table": ("Footstool / Sofastool / Bed End Stool / Stool", "Ottoman"),
    # Furniture and machines of the same outline.
    "desk": ("Dressing Table",),
    "shelf": ("Wine Cabinet", "Wine Cooler", "Cart"),
    "stove": ("WashingMachine", "ClothesDryer"),
    "bin": ("LaundryHamper", "GarbageBag"),
    # A flat picture on a wall.
    "sign": ("Painting",),
    # Upright things on a foot.
    "plant": ("RoomDecor",),
    "lamp": ("Candle",),
    # Vessels, and what is as round and upright.
    "plate": ("Bowl", "Pan"),
    "cup": _names(
        "Bottle, Kettle, PaperTowelRoll, PepperShaker, Plunger, Pot, SaltShaker, SoapBottle, "
        "SprayBottle, ToiletPaper, Vase, WineBottle"
    ),
    # Flat or thin, lying.
    "book": _names(
        "ButterKnife, CD, CellPhone, Cloth, CreditCard, Fork, KeyChain, Knife, Ladle, Pen, Pencil, "
        "RemoteControl, Spatula, Spoon"
    ),
    # Compact bodies of any kind.
    "box": _names(
        "AlarmClock, Apple, BaseballBat, BasketBall, Boots, Bread, CoffeeMachine, DishSponge, "
        "DogBed, Dumbbell, Egg, Faucet, Lettuce, Microwave, Others, Pillow, Potato, Safe, SoapBar, "
        "Statue, TableTopDecor, TeddyBear, TennisRacket, TissueBox, Toaster, Tomato, "
        "VacuumCleaner, Watch"
    ),
}

SUPER_CATEGORIES: Mapping[str, str] = {
    # 3D-FUTURE's eight, and the first words of 3D-FRONT's titles.
    "Bed": "bed",
    "Cabinet/Shelf/Desk": "cabinet",
    "Chair": "chair",
    "Lighting": "lamp",
    "Others": "box",
    "Pier/Stool": "coffee_table",
    "Sofa": "sofa",
    "Table": "table",
    # What the AeroScene authors call what stands outdoors.
    "building": "building",
}
"""Our category for the source's wider one, used if neither table knows the name."""

WORDS: Mapping[str, tuple[str, ...]] = {
    # Buildings and grounds.
    "house": ("town house", "villa", "cottage", "home"),
    "tower": ("skyscraper",),
    "warehouse": ("factory", "hangar"),
    "garage": ("shed",),
    "building": ("apartment", "office", "shop", "store", "hotel", "school", "church", "mall"),
    "canopy": ("bus stop", "gas station", "pavilion"),
    "road": ("street",),
    "sidewalk": ("pavement",),
    "lawn": ("grass",),
    "parking_lot": ("car park",),
    "water": ("pool", "pond", "lake", "fountain"),
    "fence": ("hedge", "railing", "barrier"),
    # Streets and gardens.
    "tree": ("palm",),
    "bush": ("shrub",),
    "car": ("sedan", "suv", "taxi"),
    "truck": ("lorry",),
    "bicycle": ("bike",),
    "boat": ("ship",),
    "street_lamp": ("street light", "lamp post", "light post"),
    "traffic_light": ("traffic signal",),
    "sign": ("billboard", "painting", "picture", "poster"),
    "bin": ("trash can", "garbage can", "dustbin", "trash"),
    "planter": ("flower pot",),
    "ac_unit": ("air conditioner",),
    # Rooms.
    "sofa": ("couch",),
    "armchair": ("arm chair", "lounge chair"),
    "chair": ("stool", "seat"),
    "bed": ("bunk",),
    "wardrobe": ("closet",),
    "shelf": ("book shelf", "bookcase", "bookshelf", "rack", "shelves"),
    "nightstand": ("night stand", "bedside table"),
    "coffee_table": ("side table", "end table", "tea table"),
    "cabinet": ("tv stand", "sideboard", "drawer", "dresser", "console"),
    "counter": ("countertop",),
    "fridge": ("refrigerator",),
    "stove": ("oven",),
    "television": ("tv",),
    "lamp": ("light", "chandelier"),
    "toilet": ("commode", "urinal", "lavatory", "water closet"),
    "basin": ("sink", "washbasin", "wash basin", "washstand"),
    "bath": ("bathtub", "shower tray", "shower cabin", "shower stall", "shower cubicle"),
    # What bathrooms and tables have beside, so that their first word does not decide.
    "cup": ("toilet paper", "toilet brush"),
    "book": ("bath mat", "bath towel", "cutlery", "silverware"),
}
"""Further words in names, besides the names of our categories. The last one decides: in English a
table lamp is a lamp.
"""

FORMS: Mapping[str, tuple[str, ...]] = {
    "bookcase": ("Bookcase / jewelry Armoire",),
    "bowl": ("Bowl", "Pan"),
    "glass": ("Bottle", "Cup", "SoapBottle", "SprayBottle", "Vase", "WineBottle"),
    "mug": ("Mug",),
    "open": ("Newspaper",),
    "panel": ("Painting",),
    "round": ("Round End Table",),
    "sideboard": ("Sideboard / Side Cabinet / Console Table", "TV Stand", "TVStand"),
    "swivel": ("Lounge Chair / Book-chair / Computer Chair",),
}
"""Forms of our shapes that resemble these names most."""
