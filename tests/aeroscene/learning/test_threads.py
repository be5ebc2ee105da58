"""What importing the package decides before PyTorch is loaded."""

import os
import subprocess
import sys

import pytest

PROGRAM = "import os, sys, aeroscene.learning; print(os.environ['OMP_WAIT_POLICY'], *sys.modules)"


@pytest.mark.parametrize(("given", "policy"), [(None, "PASSIVE"), ("ACTIVE", "ACTIVE")])
def test_threads_wait_asleep_unless_a_user_says_otherwise(given, policy):
    environment = {key: value for key, value in os.environ.items() if key != "OMP_WAIT_POLICY"}
    environment |= {} if given is None else {"OMP_WAIT_POLICY": given}
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM], env=environment, capture_output=True, text=True, check=True
    )
    found, *modules = done.stdout.split()
    assert found == policy
    # Once PyTorch is loaded it has no effect.
    assert "torch" not in modules
