"""How the speed follows steps of its target and of the load, from the profile of each scenario.

A step is a segment of the profile whose target differs from the one before by at least ``MIN_STEP``
of rated speed or torque; a ramp counts as a step of its whole height. Speeds are means over a
decision. If a scenario has several steps, the worst one counts. Each metric is (n,), a number per
scenario.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sensorless.evaluation.metrics.profile import reference, reference_at_starts
from sensorless.evaluation.rollout import Floats, Rollout

MIN_STEP = 0.05
SETTLED = 0.02
"""Band around the target in which the speed has to stay, over the height of the step."""
CLEAN = 0.5
"""Largest overshoot of the sensored twin that counts as none [%]."""
ALLOWED = 2.0
"""Overshoot that a drive may have where its twin has none [%]."""


@dataclass(frozen=True)
class Steps:
    """Steps in each segment; every field is (n, PROFILE_N)."""

    height: Floats
    """target minus the reference at the step [rad/s], or change of the load [N m]; NaN: no step"""
    target: Floats
    """[rad/s] or [N m]"""
    start: Floats
    """[s]"""
    first: NDArray[np.int64]
    """first decision that lies entirely in the window"""
    stop: NDArray[np.int64]
    """first decision after the window, which the next step or the drive's end closes"""

    def window(self, j: int, decisions: int) -> NDArray[np.bool_]:
        """(decisions, n): the decision is in the window of segment j."""
        rows = np.arange(decisions)[:, None]
        return np.asarray((rows >= self.first[:, j]) & (rows < self.stop[:, j]))


def overshoot_pct(r: Rollout) -> Floats:
    """100 max(0, max sign(d) (omega_m - target)) / |d|, d = target - reference before the step [%].

    The window runs to the next step of the speed target. NaN without a step.
    """
    return _worst(_overshoots(r, "omega_m"))


def overshoot_excess_pct(r: Rollout) -> Floats:
    """Largest difference, over the steps, between the overshoots of drive and twin [%]."""
    return _worst(_overshoots(r, "omega_m") - _overshoots(r, "omega_m_twin"))


def overshoot_clean_pct(r: Rollout) -> Floats:
    """``overshoot_pct`` over the speed steps in which the sensored twin's is at most 0.5 % [%].

    There the speed loop itself has none, so all overshoot comes from the estimate. NaN without such
    a step.
    """
    twin = _overshoots(r, "omega_m_twin")
    return _worst(np.where(twin <= CLEAN, _overshoots(r, "omega_m"), np.nan))


def overshoot_clean_above(r: Rollout) -> Floats:
    """1 where ``overshoot_clean_pct`` > 2 %, else 0; its mean is a share of scenarios."""
    worst = overshoot_clean_pct(r)
    return np.asarray(np.where(np.isnan(worst), np.nan, worst > ALLOWED))


def settling_s(r: Rollout) -> Floats:
    """Time from a speed step until |omega_m - target| <= 2 % of its height for good [s].

    NaN without a step, or if one of them has not settled when its window ends.
    """
    return _settling(r, "omega_m")


def settling_twin_s(r: Rollout) -> Floats:
    """``settling_s`` of the sensored twin: that of the speed loop alone [s]."""
    return _settling(r, "omega_m_twin")


def _settling(r: Rollout, name: str) -> Floats:
    """(n,) longest settling time of a speed [s]."""
    omega = r.mean(name)
    steps = _speed_steps(r)
    out = np.full(steps.height.shape, np.nan)
    for j in _used(steps):
        away = np.abs(omega - steps.target[:, j]) > SETTLED * np.abs(steps.height[:, j])
        away &= steps.window(j, len(omega))
        last = np.where(away.any(axis=0), len(omega) - 1 - away[::-1].argmax(axis=0), -1)
        time = np.maximum((last + 1) * r.decision_time - steps.start[:, j], 0.0)
        out[:, j] = np.where(last < steps.stop[:, j] - 1, time, np.inf)
    worst = _worst(np.where(np.isnan(steps.height), np.nan, out))
    return np.asarray(np.where(np.isinf(worst), np.nan, worst))


def dip_pct_s(r: Rollout) -> Floats:
    """100 sum max(0, sign(d) (omega_m_ref - omega_m)) dt / omega_m_rated, d = load step [% s].

    A load step slows the drive down, or speeds it up if it pulls. The window runs to the next step
    of load or speed target. NaN without a load step.
    """
    return _worst(_dips(r, reference(r) - r.mean("omega_m")))


def dip_excess_pct_s(r: Rollout) -> Floats:
    """Largest difference, over the load steps, between the dips of drive and twin [% s]."""
    ref = reference(r)
    drive, twin = (_dips(r, ref - r.mean(name)) for name in ("omega_m", "omega_m_twin"))
    return _worst(drive - twin)


def _changes(target: Floats, first: Floats, t: Floats) -> NDArray[np.bool_]:
    """(n, PROFILE_N): a segment begins there with a new target."""
    before = np.concatenate([first[:, None], target[:, :-1]], axis=1)
    return np.asarray((target != before) & np.isfinite(t))


def _steps(
    r: Rollout, step: NDArray[np.bool_], ends: NDArray[np.bool_], height: Floats, target: Floats
) -> Steps:
    """Steps where ``step``, with windows up to the next segment where ``ends``."""
    t, dt = r.scenarios.t, r.decision_time
    begins = np.where(ends, t, np.inf)
    after = np.full((len(t), 1), np.inf)
    following = np.concatenate([begins[:, 1:], after], axis=1)[:, ::-1]
    stop = np.minimum.accumulate(following, axis=1)[:, ::-1]
    stop = np.minimum(stop, (r.periods * r.motor.T_s)[:, None])
    start = np.where(np.isfinite(t), t, 0.0)
    first_row = np.ceil(start / dt - 1e-6).astype(np.int64)
    stop_row = np.floor(stop / dt + 1e-6).astype(np.int64)
    valid = step & (stop_row > first_row)
    return Steps(np.where(valid, height, np.nan), target, start, first_row, stop_row)


def _speed_steps(r: Rollout) -> Steps:
    s = r.scenarios
    changes = _changes(s.omega, s.omega_0, s.t)
    height = s.omega - reference_at_starts(r)
    large = np.abs(height) >= MIN_STEP * r.motor.omega_rated / r.motor.n_p
    return _steps(r, changes & large, changes, height, s.omega)


def _load_steps(r: Rollout) -> Steps:
    s = r.scenarios
    none = np.zeros(len(s))
    changes = _changes(s.tau, none, s.t)
    height = s.tau - np.concatenate([none[:, None], s.tau[:, :-1]], axis=1)
    large = np.abs(height) >= MIN_STEP * r.motor.tau_rated
    ends = changes | _changes(s.omega, s.omega_0, s.t)
    return _steps(r, changes & large, ends, height, s.tau)


def _used(steps: Steps) -> list[int]:
    """Segments that are a step in any scenario."""
    return [int(j) for j in np.flatnonzero(~np.isnan(steps.height).all(axis=0))]


def _overshoots(r: Rollout, name: str) -> Floats:
    """(n, PROFILE_N) overshoot of each speed step [%]."""
    key = f"overshoots of {name}"
    if key in r.kept:
        return r.kept[key]
    omega = r.mean(name)
    steps = _speed_steps(r)
    out = np.full(steps.height.shape, np.nan)
    for j in _used(steps):
        height = steps.height[:, j]
        beyond = np.sign(height) * (omega - steps.target[:, j])
        peak = np.where(steps.window(j, len(omega)), beyond, 0.0).max(axis=0, initial=0.0)
        out[:, j] = 100.0 * peak / np.abs(height)
    r.kept[key] = out
    return out


def _dips(r: Rollout, below: Floats) -> Floats:
    """(n, PROFILE_N) dip after each load step [% s], from (d, n) reference minus speed."""
    steps = _load_steps(r)
    rated = r.motor.omega_m_rated
    out = np.full(steps.height.shape, np.nan)
    for j in _used(steps):
        sign = np.sign(steps.height[:, j])
        lack = np.where(steps.window(j, len(below)), sign * below, 0.0)
        area = np.maximum(lack, 0.0).sum(axis=0) * r.decision_time
        out[:, j] = np.where(np.isnan(sign), np.nan, 100.0 * area / rated)
    return out


def _worst(of_steps: Floats) -> Floats:
    """Largest value of each row; NaN if all of the row is."""
    return np.asarray(np.fmax.reduce(of_steps, axis=1))
