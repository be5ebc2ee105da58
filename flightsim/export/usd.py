"""USD: the scene with physics and semantics, for Isaac Sim and other USD programs.

`/World` holds the objects in their hierarchy. Each is an Xform with its label (taxonomy `class`),
meshes under `looks` and colliders under `solids`: static, because no rigid body is above them. The
vehicle is a rigid body with the mass and the inertia of its airframe. Metres, z up.
"""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path

from aeroscene.files.names import file_name
from flightsim.export.files import ExportError, staged
from flightsim.world import World


def write_usd(world: World, folder: Path) -> Path:
    """Write `<scene>.usdc` and its textures into a folder and return the path of the stage.

    Args:
        world: World to write.
        folder: Destination, which is made if it is missing.

    Raises:
        ExportError: If usd-core is not installed or the folder cannot be written.
    """
    if find_spec("pxr") is None:
        raise ExportError(
            "to 'usd' needs usd-core, which is not installed; "
            "valid: mjcf, glb, or usd after pip install usd-core"
        )
    # Only here: usd-core is an extra, and the command line must work without it.
    from flightsim.export.usd_stage import write_stage

    name = f"{file_name(world.scene.scene_id)}.usdc"
    with staged(folder) as stage_folder:
        write_stage(world, stage_folder / name)
    return folder / name
