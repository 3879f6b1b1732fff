"""Signs and delay from the answer of the current, on every shipped machine."""

from collections import Counter
from collections.abc import Iterator

import numpy as np
import pytest

from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.words import plan_from
from sensorless.evaluation.trace import trace
from sensorless.machine.magnetics import Floats
from sensorless.machine.motor import MOTORS, Motor
from sensorless.machine.phases import clarke
from sensorless.policies.registry import make_policy
from sensorless.replay.channels import of_size
from sensorless.replay.signature import of_voltage

WAYS = {
    (1, 0): "",
    (1, 1): "try --delay 1",
    (1, 2): "try --delay 2",
    (1, -1): "move the columns of the voltage one row up",
    (-1, 0): "turn the sign of all currents with --map, as in i_a=-i_a",
    (-1, 1): "turn the sign of all currents with --map, as in i_a=-i_a, and try --delay 1",
}
"""What to do by the sign of the currents in a log, and the rows from a voltage to where it acts."""
Pair = tuple[Floats, Floats]


@pytest.fixture(scope="module")
def recorded() -> dict[str, Pair]:
    """Voltage in each row's period and current, from standstill to 0.4 of rated speed."""
    out = {}
    for name in sorted(path.stem for path in MOTORS.glob("*.toml")):
        motor = Motor.load(name)
        n, tau = motor.n_rated_rpm, motor.tau_rated
        case = plan_from(f"0:{0.4 * n}", f"0:0,0.15:{0.4 * tau}", 2.0 * n, 0.3, motor, 3)
        run = trace(make_policy("eq25", motor), case, motor, DriveDesign(carrier=True))
        phases = np.stack([run["i_a"], run["i_b"], -run["i_a"] - run["i_b"]], axis=-1)
        out[name] = np.stack([run["u_alpha_hat"], run["u_beta_hat"]], axis=-1), clarke(phases)
    return out


def test_a_voltage_that_turns_without_noise_tells_no_order_of_phases() -> None:
    """Of a right log at constant speed without injection, where both turn with the rotor."""
    turn = np.exp(1j * 0.09 * np.arange(4000))
    noise = np.random.default_rng(2).normal(0.0, 1e-3, (4000, 2))
    u, i = 180.0 * turn, 9.0 * turn * np.exp(-0.77j)
    pair = np.stack([u.real, u.imag], axis=-1), np.stack([i.real, i.imag], axis=-1) + noise
    assert not any("another order" in note for note in of_voltage(*pair, 0))


def told(pair: Pair, sign: int, rows: int, delay: int = 0) -> list[str]:
    """The cures for a log with this mistake, read with ``delay``."""
    u = np.roll(pair[0], 1 + delay - rows, axis=0)
    u[: 1 + delay] = 0.0
    u[len(u) + min(1 + delay - rows, 0) :] = 0.0
    notes = list(of_voltage(u, sign * pair[1], delay))
    return notes[0].split(": ", 1)[1].split(" or ") if notes else [""]


def every(recorded: dict[str, Pair]) -> Iterator[tuple[tuple[int, int], list[str]]]:
    for pair in recorded.values():
        for way in WAYS:
            yield way, told(pair, *way)


def test_no_right_log_is_blamed(recorded: dict[str, Pair]) -> None:
    for name, pair in recorded.items():
        for delay in range(3):
            assert told(pair, 1, delay, delay) == [""], (name, delay)


def test_a_mistake_is_named_or_at_least_among_what_may_be(recorded: dict[str, Pair]) -> None:
    """Two rows off, or two mistakes at once, may stay unseen: the injection looks right then."""
    seen: Counter[str] = Counter()
    for way, cures in every(recorded):
        if way == (1, 0):
            continue
        hidden = way in ((1, 2), (-1, 1)) and cures == [""]
        assert hidden or WAYS[way] in cures, (way, cures)
        seen["hidden" if hidden else "one" if len(cures) == 1 else "among"] += 1
    assert seen["one"] >= 0.6 * seen.total()
    assert seen["hidden"] <= 0.15 * seen.total()


def test_an_answer_of_another_size_is_named(recorded: dict[str, Pair]) -> None:
    for name, (voltage, i) in recorded.items():
        motor, u = Motor.load(name), np.roll(voltage, 1, axis=0)
        assert list(of_size(u, i, motor)) == [], name
        for factor, word in ((1e-3, "times smaller"), (1e3, "times larger")):
            (said,) = of_size(u, factor * i, motor)
            assert word in said and f"rated {motor.i_rated:.3g} A" in said
