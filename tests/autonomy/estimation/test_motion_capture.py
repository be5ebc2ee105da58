"""Motion capture pulls an estimate to the millimetre, late as it is."""

import numpy as np
from scipy.spatial.transform import Rotation

from autonomy.estimation.motion_capture import fuse_mocap
from autonomy.estimation.past import restart_past
from autonomy.estimation.predict import predict
from tests.autonomy.sample_filters import DT, G, add_error, moving_filter


def test_late_poses_pull_a_wrong_estimate_onto_the_moving_truth():
    velocity = np.array([3.0, -1.0, 0.5])
    f = moving_filter(velocity)
    add_error(f, np.concatenate([[0.3, -0.2, 0.1, 0.1, 0.0, 0.0, 0.0, 0.0, 0.02], np.zeros(16)]))
    restart_past(f)
    for k in range(1, 200):
        predict(f, np.array([0.0, 0.0, G]), np.zeros(3))
        if k % 2 == 0:
            fuse_mocap(f, velocity * (k - 2) * DT, 0.0, 2)
    np.testing.assert_allclose(f["position_enu_m"], velocity * 199 * DT, atol=1e-3)
    np.testing.assert_allclose(f["velocity_enu_mps"], velocity, atol=5e-3)
    yaw = Rotation.from_quat(f["quat_wxyz"], scalar_first=True).as_euler("ZYX")[0]
    assert abs(yaw) < 2e-3
    assert f["last_position_tick"] == 198
