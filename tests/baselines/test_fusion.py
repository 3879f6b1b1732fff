"""Inverse-variance fusion against the Kalman filter of a library."""

from collections.abc import Callable

import numpy as np
import pytest
from filterpy.kalman import KalmanFilter

from sensorless.baselines.fusion import InnovationFusion
from sensorless.policy import Signals

Make = Callable[..., Signals]


@pytest.fixture
def fusion() -> InnovationFusion:
    return InnovationFusion("fusion", floor=np.deg2rad(3.0), bias=0.02, slope=0.78)


def kalman(r_hfi: float, r_smo: float, theta_hfi: float, theta_smo: float) -> float:
    """Angle of a filter that measures one constant twice, without prior knowledge."""
    reference = KalmanFilter(dim_x=1, dim_z=2)
    reference.H = np.ones((2, 1))
    reference.R = np.diag([r_hfi, r_smo])
    reference.P *= 1e6
    reference.update(np.array([[theta_hfi], [theta_smo]]))
    return float(reference.x[0, 0])


def test_the_blend_is_a_kalman_filters_update(fusion: InnovationFusion, signals: Make) -> None:
    rng = np.random.default_rng(1)
    n = 50
    obs = signals(
        hfi_residual=rng.uniform(0, 0.3, n),
        smo_residual=rng.uniform(0, 0.3, n),
        emf=rng.uniform(0.05, 0.5, n),
    )
    k_s = fusion.act(obs)
    r_hfi, r_smo = fusion.variances(obs)
    for j in np.flatnonzero(k_s > 0.0):
        blend = k_s[j] * 0.3 + (1.0 - k_s[j]) * -0.2
        assert blend == pytest.approx(kalman(r_hfi[j], r_smo[j], 0.3, -0.2), abs=1e-6)


def test_variances_are_in_rad_squared(fusion: InnovationFusion, signals: Make) -> None:
    obs = signals(hfi_residual=0.2, smo_residual=0.4, emf=0.1)
    r_hfi, r_smo = fusion.variances(obs)
    assert r_hfi == pytest.approx((0.1 / 0.78) ** 2 + np.deg2rad(3.0) ** 2)
    assert r_smo == pytest.approx(0.2**2 + 0.2**2)


def test_each_residual_moves_the_weight_to_the_other(
    fusion: InnovationFusion, signals: Make
) -> None:
    k_s = fusion.act(signals(hfi_residual=[0.1, 0.4, 0.1], smo_residual=[0.1, 0.1, 0.4], emf=0.3))
    assert k_s[1] < k_s[0] < k_s[2]


def test_ends(fusion: InnovationFusion, signals: Make) -> None:
    k_s = fusion.act(signals(emf=[0.0, 1.0], hfi_residual=[0.0, 0.3]))
    assert k_s[0] == pytest.approx(1.0)
    assert k_s[1] == 0.0, "below the cut the injection may stop"
    assert fusion.act(signals(emf=np.nan))[0] == 1.0
