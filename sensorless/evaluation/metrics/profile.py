"""What a scenario asks of a drive over time, at the middle of each decision."""

import numpy as np

from sensorless.envs.scenarios.scenario import U_DC_TIME
from sensorless.evaluation.rollout import Floats, Rollout


def middles(r: Rollout) -> Floats:
    """(d, 1) time at the middle of each decision [s]."""
    return np.asarray((np.arange(len(r.sums))[:, None] + 0.5) * r.decision_time)


def reference(r: Rollout) -> Floats:
    """(d, n) speed reference at the middle of each decision [rad/s], mechanical."""
    if "omega_m_ref" in r.kept:
        return r.kept["omega_m_ref"]
    s = r.scenarios
    t = middles(r)
    at_start = reference_at_starts(r)
    out = np.zeros((len(t), len(s)))
    for j in range(s.t.shape[1]):
        some = _while(r, t[:, 0], j)
        time = t[some] - s.t[:, j]
        moved = _moved(at_start[:, j], s.omega[:, j], s.omega_rate[:, j], time)
        np.copyto(out[some], moved, where=time >= 0.0)
    r.kept["omega_m_ref"] = out
    return out


def reference_at_starts(r: Rollout) -> Floats:
    """(n, PROFILE_N) speed reference when each segment begins [rad/s]."""
    s = r.scenarios
    return _at_starts(r, s.omega_0, s.omega, s.omega_rate)


def since_change(r: Rollout) -> Floats:
    """(d, n) time since reference, load and DC link came to rest [s]; below 0 while one moves.

    The start of the scenario counts as a change, and so does the whole of a start sequence.
    """
    if "since_change" in r.kept:
        return r.kept["since_change"]
    s, t = r.scenarios, middles(r)
    n, segments = s.t.shape
    begins = np.concatenate([s.t[:, 1:], np.full((n, 1), np.inf)], axis=1)
    end = np.where(np.arange(segments) == 0, 0.0, np.full((n, segments), -np.inf))
    rate_dc = np.full(s.t.shape, 1.0 / U_DC_TIME)
    for first, target, rate in (
        (s.omega_0, s.omega, s.omega_rate),
        (np.zeros(n), s.tau, s.tau_rate),
        (s.u_dc[:, 0], s.u_dc, rate_dc),
    ):
        way = np.abs(target - _at_starts(r, first, target, rate))
        end = np.where(way > 0.0, np.fmax(end, s.t + way / rate), end)
    out = np.zeros((len(t), n))
    last = np.zeros(n)
    for j in range(segments):
        some = _while(r, t[:, 0], j)
        np.subtract(t[some], np.fmax(last, end[:, j]), out=out[some], where=t[some] >= s.t[:, j])
        last = np.fmax(last, np.fmin(end[:, j], begins[:, j]))
    starting = r.sums["starting"] > 0.0
    if starting.any():
        begun = starting.sum(axis=0) * r.decision_time
        out = np.minimum(out, np.where(begun > 0.0, t - begun, np.inf))
    r.kept["since_change"] = out
    return out


def _while(r: Rollout, t: Floats, j: int) -> slice:
    """Decisions at times ``t`` in which segment j of any scenario runs: later ones overrule it."""
    begin, after = r.scenarios.t[:, j], r.scenarios.t[:, j + 1 : j + 2]
    stop = after.max(initial=0.0) if after.size else np.inf
    return slice(np.searchsorted(t, begin.min(initial=np.inf)), np.searchsorted(t, stop))


def _moved(x: Floats, target: Floats, rate: Floats, time: Floats) -> Floats:
    """Value at ``time`` after x began to move to its target."""
    with np.errstate(invalid="ignore"):
        reach = np.where(time > 0.0, rate * time, 0.0)
    return np.asarray(x + np.clip(target - x, -reach, reach))


def _at_starts(r: Rollout, first: Floats, target: Floats, rate: Floats) -> Floats:
    """(n, PROFILE_N) value of a quantity of the profile when each segment begins."""
    s = r.scenarios
    out = np.empty(s.t.shape)
    out[:, 0] = first
    start = np.minimum(s.t, s.duration[:, None])
    for j in range(1, s.t.shape[1]):
        time = start[:, j] - start[:, j - 1]
        out[:, j] = _moved(out[:, j - 1], target[:, j - 1], rate[:, j - 1], time)
    return out
