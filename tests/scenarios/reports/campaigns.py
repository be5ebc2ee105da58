"""Folders of campaigns that nobody flew."""

import json

from scenarios.campaigns.campaign import open_campaign
from scenarios.campaigns.flyer import Suite, Trial
from scenarios.campaigns.store import JOURNAL, open_store
from scenarios.tasks.recipe import Recipe

WAY = [[0.0, 0.0, 1.0], [5.0, 5.0, 3.0], [10.0, 0.0, 1.0]]


def row(trial, success, **more):
    """Row of a trial that flew."""
    return {
        "trial_id": trial.id,
        "scene": trial.scene,
        "vehicle": trial.vehicle,
        "trial": trial.number,
        "success": success,
        "navigated": success,
        "code": "landed" if success else "contact",
        "reason": "landed" if success else "touched object 3 (house)",
        "seed": 100 + trial.number,
        "start": [0.0, 0.0, 0.0],
        "area": 0,
        "difficulty": ("easy", "medium", "hard")[trial.number % 3],
        "way_m": 20.0 + trial.number,
        "wind_mps": 1.5,
        "least_navigation_s": 2.0,
        "navigation_s": 8.0 + trial.number,
        "flight_s": 20.0 + trial.number,
        "touchdown_error_m": 0.1,
        "least_clearance_m": 0.4 if success else -0.2,
        "energy_j": 2000.0 + trial.number,
        "jerk_rms_mps3": 2.0,
        "flown_enu_m": WAY,
        "planned_enu_m": WAY,
        **more,
    }


def campaign(folder, rows, *, pilot="demo", recipe=None):
    """Make the folder of a campaign with these rows."""
    with open_campaign(folder, Suite(pilot=pilot, recipe=recipe or Recipe())):
        pass
    with open_store(folder) as store:
        for each in rows:
            store.add(each)
    assert not (folder / JOURNAL).read_bytes()
    return folder


def trials(n, scene="7", vehicle="iris"):
    """The first trials of a scene and a vehicle."""
    return [Trial(scene, vehicle, number) for number in range(n)]


def change_manifest(folder, **more):
    """Change fields of a campaign's manifest."""
    path = folder / "campaign.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | more))
