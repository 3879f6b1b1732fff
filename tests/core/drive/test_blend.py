"""The weighted angle and the rate limit on its weight."""

import math
from collections.abc import Callable

import numpy as np
import pytest

Call = Callable[..., None]


def blend(c: Call, hfi: tuple[float, float], smo: tuple[float, float], k_s: float) -> list[float]:
    y = np.empty(2, dtype=np.float32)
    c("blend", np.array(hfi, np.float32), np.array(smo, np.float32), k_s, y)
    return [float(v) for v in y]


def slew(c: Call, k_s: float, target: float, step: float) -> float:
    y = np.empty(1, dtype=np.float32)
    c("slew", k_s, target, step, y)
    return float(y[0])


@pytest.mark.parametrize("k_s", [0.0, 0.25, 0.5, 1.0])
@pytest.mark.parametrize(
    ("hfi_deg", "smo_deg"),
    [(359.0, 1.0), (1.0, 359.0), (-179.0, 179.0), (170.0, -170.0), (30.0, 40.0)],
)
def test_shortest_way(c: Call, hfi_deg: float, smo_deg: float, k_s: float) -> None:
    """The blend lies on the short arc: 359 and 1 degree give 0, not 180."""
    hfi, smo = (math.remainder(math.radians(a), 2 * math.pi) for a in (hfi_deg, smo_deg))
    theta, _ = blend(c, (hfi, 0.0), (smo, 0.0), k_s)
    want = smo_deg + k_s * math.remainder(hfi_deg - smo_deg, 360.0)
    assert abs(math.remainder(math.degrees(theta) - want, 360.0)) < 1e-4
    assert abs(theta) <= math.pi * (1.0 + 1e-6)


def test_half_way_between_359_and_1_is_0(c: Call) -> None:
    """The printed formula would give 180 degrees here."""
    one = math.radians(1.0)
    assert abs(blend(c, (-one, 0.0), (one, 0.0), 0.5)[0]) < 1e-6


@pytest.mark.parametrize(("k_s", "theta", "omega"), [(1.0, 0.3, 50.0), (0.0, -0.2, 80.0)])
def test_ends_are_the_estimators(c: Call, k_s: float, theta: float, omega: float) -> None:
    """Weight 1 is the injection estimator, weight 0 the sliding-mode one."""
    assert blend(c, (0.3, 50.0), (-0.2, 80.0), k_s) == pytest.approx([theta, omega], rel=1e-6)


def test_speed_is_the_weighted_mean(c: Call) -> None:
    """Speeds blend like angles."""
    assert blend(c, (0.0, 40.0), (0.0, 80.0), 0.75)[1] == pytest.approx(50.0)


def test_slew_limit(c: Call) -> None:
    """The weight moves by at most its step and arrives exactly."""
    assert slew(c, 0.5, 1.0, 0.01) == pytest.approx(0.51)
    assert slew(c, 0.5, 0.0, 0.01) == pytest.approx(0.49)
    assert slew(c, 0.995, 1.0, 0.01) == 1.0
    k_s = 1.0
    for _ in range(100):
        k_s = slew(c, k_s, 0.0, 0.0101)
    assert k_s == 0.0


@pytest.mark.parametrize(
    ("target", "end"), [(7.0, 1.0), (-3.0, 0.0), (math.nan, 1.0), (math.inf, 1.0), (-math.inf, 0.0)]
)
def test_bad_targets(c: Call, target: float, end: float) -> None:
    """Targets outside [0, 1] are clipped; NaN means injection."""
    assert slew(c, 0.5, target, 1.0) == end
