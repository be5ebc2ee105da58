"""Flies by AirSim's published client, and prints what it saw; a process of its own."""

import contextlib
import io
import json
import sys

import cosysairsim as airsim


def main() -> None:
    """Fly up, look, come back."""
    client = airsim.MultirotorClient(port=int(sys.argv[1]))
    with contextlib.redirect_stdout(io.StringIO()):
        client.confirmConnection()
    client.reset()
    client.enableApiControl(True)
    client.armDisarm(True)
    client.takeoffAsync().join()
    client.moveToPositionAsync(2, 1, -4, 3).join()
    top = client.getMultirotorState().kinematics_estimated.position
    kind = airsim.ImageType.DepthPlanar
    (depth,) = client.simGetImages([airsim.ImageRequest("bottom_center", kind, True)])
    try:
        client.simListAssets()
        refused = ""
    except Exception as error:  # noqa: BLE001 - the client has no narrower one
        refused = str(error.args[0])
    client.moveToPositionAsync(0, 0, -1, 3).join()
    client.landAsync().join()
    client.armDisarm(False)
    end = client.getMultirotorState().kinematics_estimated.position
    found = {
        "top": [top.x_val, top.y_val, top.z_val],
        "end": [end.x_val, end.y_val, end.z_val],
        "refused": refused,
        "depth": list(airsim.get_pfm_array(depth).shape),
    }
    sys.stdout.write(json.dumps(found))


main()
