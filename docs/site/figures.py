"""Pictures of the theory pages: ``python -m docs.site.figures`` draws them anew into ``docs/``."""

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from sensorless.core.api import SIGNAL_N, SIGNAL_NAMES
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.words import plan_from
from sensorless.evaluation.steady import Steady, make_ideal, steady
from sensorless.evaluation.trace import Trace, trace
from sensorless.machine.magnetics import (
    Floats,
    apparent_q_inductance,
    cross_angle,
    flux,
    inverse_inductance,
    mtpa,
    torque,
)
from sensorless.machine.motor import Motor
from sensorless.plots.figure import COLOURS, new_figure, save
from sensorless.policies.registry import make_policy
from sensorless.policy import TablePolicy, design_for
from sensorless.units import RAD_S_TO_RPM

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ROOT = Path(__file__).parents[2]
PROGRESS = ROOT / "results" / "reference" / "progress.csv"
MOTOR = Motor.load("paper")
WIDE = (9.0, 3.6)
SHADES = ("#8d99ae", "#2e86ab", "#d1495b", "#f2a541")


def injection(points: int) -> "Figure":
    """Error signal over the angle error, and where it locks under load."""
    figure, ((left, right),) = new_figure(WIDE, columns=2)
    line = mtpa(MOTOR)
    tau = torque(MOTOR, line)
    e = np.linspace(-np.pi / 2, np.pi / 2, 181)
    for wanted, colour in zip((0.0, 6.0, 14.0), SHADES, strict=False):
        here = line[[np.argmin(np.abs(tau - wanted))]]
        (gamma,) = inverse_inductance(MOTOR.saturation, flux(MOTOR.saturation, here))
        answer = gamma @ np.array([np.cos(e), -np.sin(e)])
        d = np.cos(e) * answer[0] - np.sin(e) * answer[1]
        q = np.sin(e) * answer[0] + np.cos(e) * answer[1]
        left.plot(np.rad2deg(e), q / np.hypot(d, q), color=colour, label=f"{wanted:g} N m")
    left.set(xlabel="rotor − estimate [° el.]", ylabel="error signal [1]")
    loads = np.linspace(-14.0, 14.0, points)
    for cross, colour in (("none", SHADES[2]), ("table", SHADES[1])):
        design = DriveDesign(estimator="smo", cross=cross)
        found = steady(MOTOR, design, np.full(points, 150.0), loads, 1.0, settle=1.2)
        label = "measured" if cross == "none" else "compensated by the curve"
        right.plot(loads, np.rad2deg(found.err_hfi), "o", ms=4, color=colour, label=label)
        if cross == "none":
            angle = np.rad2deg(cross_angle(MOTOR, found.i))
            right.plot(loads, angle, color=SHADES[0], zorder=0, label="closed form")
    right.set(xlabel="torque [N m]", ylabel="rotor − estimate [° el.]", xlim=(-15, 15))
    return _finished(figure)


def sliding_mode(points: int) -> "Figure":
    """Lag of the sigmoid over the speed, and the angle that a low L_q costs over the torque."""
    figure, ((left, right),) = new_figure(WIDE, columns=2)
    rpm = np.linspace(200.0, 1200.0, points)
    omega = np.asarray(MOTOR.rpm_to_electrical(1.0)) * rpm
    for gain, colour in ((1.0, SHADES[1]), (0.4, SHADES[2])):
        g = gain * MOTOR.L_d / MOTOR.T_s
        lag = np.angle(g / (g + MOTOR.R_s + 1j * omega * MOTOR.L_q))
        left.plot(rpm, np.rad2deg(-lag), color=colour, label=f"left as it is, g = {g:.0f} V/A")
        design = _smo(1.0, lag_cure=False, smo_gain=gain)
        found = _held(design, rpm, np.zeros(points))
        left.plot(rpm, np.rad2deg(found.err_smo), "o", ms=4, color=colour)
    found = _held(_smo(1.0), rpm, np.zeros(points))
    left.plot(rpm, np.rad2deg(found.err_smo), "o", ms=4, color=SHADES[0], label="removed")
    left.set(xlabel="speed [r/min]", ylabel="rotor − estimate [° el.]")
    loads = np.linspace(1.0, 13.0, points)
    line = mtpa(MOTOR)[1:]
    for bias, colour in ((0.7, SHADES[2]), (0.9, SHADES[1]), (1.0, SHADES[0])):
        found = _held(_smo(bias), np.full(points, 600.0), loads)
        psi = flux(MOTOR.saturation, found.i)
        known = np.interp(found.i_q_hat, line[:, 1], apparent_q_inductance(MOTOR, line))
        low = bias * known[:, None] * found.i
        theory = np.arctan2(psi[:, 1] - low[:, 1], psi[:, 0] - low[:, 0])
        right.plot(loads, np.rad2deg(-theory), color=colour, label=f"{bias:g} of L_q")
        right.plot(loads, np.rad2deg(found.err_smo), "o", ms=4, color=colour)
    right.set(xlabel="torque at 600 r/min [N m]", ylabel="rotor − estimate [° el.]")
    return _finished(figure)


def blend(points: int) -> "Figure":
    """Weights of three rules over the speed, and one hand-over under Eq. 25 on two estimators."""
    figure, ((left, right),) = new_figure(WIDE, columns=2)
    obs = np.zeros((40 * points, SIGNAL_N), dtype=np.float32)
    obs[:, SIGNAL_NAMES.index("speed")] = np.linspace(0.0, 0.6, len(obs))
    for name, colour in zip(("eq25", "linear-coupled-tuned", "reference"), SHADES, strict=False):
        speed = MOTOR.n_rated_rpm * obs[:, 0]
        left.plot(speed, make_policy(name, MOTOR).act(obs), color=colour, label=name)
    left.set(xlabel="speed [r/min], no load", ylabel="$k_s$")
    t = _run("sliding_mode", "0:200,0.3:600", "0:6", 0.06 * points)
    for key, name in (
        ("theta_e_err_hfi", "hfi"),
        ("theta_e_err_smo", "smo"),
        ("theta_e_err", "blend"),
    ):
        right.plot(t["t"], np.rad2deg(t[key]), color=COLOURS[name], lw=1, label=name)
    right.plot(t["t"], 10.0 * t["k_s"], color=COLOURS["ref"], label="10 $k_s$")
    right.set(xlabel="time [s], from 200 to 600 r/min with 6 N m", xlim=(0.3, 0.8), ylim=(-8, 12))
    right.set_ylabel("rotor − estimate [° el.]")
    return _finished(figure)


def coupled(points: int) -> "Figure":
    """A rated load step on three drives: what the speed estimate lags, and what the torque does."""
    figure, ((left, right),) = new_figure(WIDE, columns=2)
    for name, colour in zip(("sliding_mode", "flux_observer", "eq25"), SHADES[1:], strict=True):
        t = _run(name, "0:350", "0:0,0.2:14", 0.06 * points)
        label = {"eq25": "coupled observer"}.get(name, name.replace("_", " "))
        lag = (t["omega_m"] - t["omega_m_hat"]) * RAD_S_TO_RPM
        dash = "--" if name == "flux_observer" else "-"
        left.plot(t["t"], lag, dash, color=colour, lw=1.2, label=label)
        torques = _mean(t["tau"] - t["tau_twin"])
        right.plot(t["t"], torques, dash, color=colour, lw=1.2, label=label)
    left.set(xlabel="time [s]", ylabel="speed − its estimate [r/min]", xlim=(0.15, None))
    right.set(xlabel="time [s]", ylabel="torque − that with a sensor [N m]", xlim=(0.15, None))
    return _finished(figure)


def learning(points: int) -> "Figure":
    """Validation of the reference over its training, and the table that came out."""
    figure, ((left, right),) = new_figure(WIDE, columns=2)
    rows = np.genfromtxt(PROGRESS, delimiter=",", names=True)
    labels = {"torque_dev": "torque deviation", "torque_ripple": "ripple", "objective": "objective"}
    for (name, label), colour in zip(labels.items(), SHADES[1:], strict=True):
        change = 100.0 * (rows[name] / rows[name][0] - 1.0)
        left.plot(1e-6 * rows["steps"], change, color=colour, label=label)
    left.set(xlabel="decisions [millions]", ylabel="in validation, against Eq. 25 [%]")
    policy = make_policy("reference", MOTOR)
    assert isinstance(policy, TablePolicy)
    across = np.linspace(-45.0, 45.0, 10 * points)
    along = np.linspace(0.0, 900.0, 10 * points)
    obs = np.zeros((len(across) * len(along), SIGNAL_N), dtype=np.float32)
    grid = np.meshgrid(along / MOTOR.n_rated_rpm, across / 30.0)
    for name, values in zip(("speed", "disagreement"), grid, strict=True):
        obs[:, SIGNAL_NAMES.index(name)] = values.ravel()
    mesh = right.pcolormesh(
        along, across, policy.act(obs).reshape(grid[0].shape), cmap="cividis", vmin=0, vmax=1
    )
    figure.colorbar(mesh, ax=right, label="$k_s$")
    right.set(xlabel="speed [r/min]", ylabel="disagreement [° el.]")
    left.grid(alpha=0.3)
    left.legend(fontsize=8, frameon=False)
    return figure


FIGURES: dict[str, Callable[[int], "Figure"]] = {
    "injection": injection,
    "sliding-mode": sliding_mode,
    "blend": blend,
    "coupled": coupled,
    "learning": learning,
}
"""File in ``docs/`` without its end, and what draws it with a number of points."""


def _smo(bias: float, *, lag_cure: bool = True, smo_gain: float = 1.0) -> DriveDesign:
    """Drive on the sliding-mode observer with one share of L_q, as a motor and as a generator."""
    return DriveDesign(
        estimator="smo", L_q_bias=bias, L_q_motoring=bias, lag_cure=lag_cure, smo_gain=smo_gain
    )


def _held(design: DriveDesign, rpm: Floats, tau: Floats) -> Steady:
    """Hold the sliding-mode observer alone, with exact sensors and inverter."""
    return steady(MOTOR, design, rpm, tau, 0.0, settle=1.2, change=make_ideal)


def _run(policy: str, speed: str, load: str, duration: float) -> Trace:
    rule = make_policy(policy, MOTOR)
    case = plan_from(speed, load, 1000.0, duration, MOTOR, 1)
    return trace(rule, case, MOTOR, design_for(rule, DriveDesign()))


def _mean(x: Floats) -> Floats:
    """Mean over two periods: without the injected part."""
    return np.convolve(x, [0.5, 0.5], mode="same")


def _finished(figure: "Figure") -> "Figure":
    for ax in figure.axes:
        ax.grid(alpha=0.3)
        ax.legend(fontsize=8, frameon=False)
    return figure


def main(words: list[str] | None = None) -> None:
    """Draw all pictures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=ROOT / "docs", help="folder to write to")
    parser.add_argument("--points", type=int, default=15, help="points of a curve")
    given = parser.parse_args(words)
    for name, draw in FIGURES.items():
        save(draw(given.points), given.out / f"{name}.png")
        print(f"wrote {given.out / name}.png")


if __name__ == "__main__":
    main()
