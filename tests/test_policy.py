"""A table as a policy is the lookup of the firmware."""

import numpy as np
from numpy.typing import NDArray

from sensorless.core.api import SIGNAL_N, SIGNAL_NAMES, SIM, Array
from sensorless.policy import Policy, Signals, TablePolicy, decide
from sensorless.table.ks_table import Axis, KsTable


def test_bilinear_weights_clipped_at_the_edges() -> None:
    values = np.array([[1.0, 0.5], [0.25, 0.0]], dtype=np.float32)
    axes = (Axis("speed", 0.0, 1.0, 2), Axis("torque_current", -1.0, 1.0, 2))
    policy: Policy = TablePolicy("table", KsTable(axes, values))
    obs = np.zeros((4, SIGNAL_N), dtype=np.float32)
    obs[:, SIGNAL_NAMES.index("speed")] = [0.0, 0.5, 1.0, 9.0]
    obs[:, SIGNAL_NAMES.index("torque_current")] = [-1.0, 0.0, 0.5, -7.0]
    policy.reset(4)
    np.testing.assert_allclose(policy.act(obs), [1.0, 0.4375, 0.0625, 0.25], atol=1e-6)
    assert (policy.name, policy.sensored) == ("table", False)


def test_only_a_privileged_policy_sees_the_drives() -> None:
    class Knowing(TablePolicy):
        def act_knowing(self, obs: Signals, sims: Array) -> NDArray[np.float32]:
            return np.asarray(sims["drive"]["y"]["omega_m"], dtype=np.float32)

    table = KsTable((Axis("speed", 0.0, 1.0, 2),), np.array([0.25, 0.25], dtype=np.float32))
    obs, sims = np.zeros((2, SIGNAL_N), dtype=np.float32), np.zeros(2, dtype=SIM)
    assert decide(TablePolicy("table", table), obs, sims).tolist() == [0.25, 0.25]
    assert decide(Knowing("knowing", table), obs, sims).tolist() == [0.0, 0.0]
