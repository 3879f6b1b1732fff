"""The test of core/drive/lock.h that looks at the answer to the injection."""

from collections.abc import Callable

import numpy as np
import pytest

from sensorless.core.api import Array, lib, struct_dtype
from sensorless.design.drive import DriveDesign
from sensorless.design.records import control_record
from sensorless.machine.motor import Motor
from sensorless.observers.hfi_design import hf_current

Call = Callable[..., None]

MOTOR = Motor.load("ipmsm_2200w")
"""The least saliency of the shipped ones."""


def answered(
    c: Call,
    parts: list[tuple[float, float, float]],
    estimator: str = "coupled",
    k_s: float = 1.0,
    i_q: float | None = None,
    motor: Motor = MOTOR,
) -> Array:
    """State after parts of a time [s], a share of the current at no load, and whether it counts."""
    i_q = 0.5 * motor.i_rated if i_q is None else i_q
    params = control_record(motor, DriveDesign(estimator=estimator))["lock"].reshape(1)
    state, every = np.zeros(1, dtype=struct_dtype("lock_state_t")), float(1.0 / params["inv_t"][0])
    for seconds, share, valid in parts:
        row = [share * hf_current(motor), valid, k_s, i_q]
        rows = np.array([row] * round(seconds / every), dtype=np.float32)
        c("lock_answer", params.copy(), state, rows, len(rows))
    (row,) = state
    return np.asarray(row)


@pytest.mark.parametrize(
    ("delta", "told"), [(0, False), (30, False), (57, False), (63, True), (90, True)]
)
def test_which_angles_the_answer_tells(c: Call, delta: int, told: bool) -> None:
    """At rest and at any speed: a rotor beside the injected axis answers with less current."""
    off = np.sin(np.deg2rad(delta)) ** 2
    x = answered(c, [(0.2, 1.0 - off + off * MOTOR.L_d / MOTOR.L_q, 1.0)])
    assert x["alarm"] == told
    assert x["reason"] == (lib.LOCK_ANSWER if told else 0)


def test_an_answer_the_other_way_is_told_at_once_and_ends_with_the_injection(c: Call) -> None:
    """A voltage that acts a period late has the wrong sign."""
    assert answered(c, [(0.1, 1.0, 1.0), (0.005, -1.0, 1.0)])["alarm"] == 1
    x = answered(c, [(0.1, -1.0, 1.0), (0.04, -1.0, 0.0)])
    assert x["alarm"] == 0 and x["alarms"] == 1
    assert x["reason"] == lib.LOCK_ANSWER


@pytest.mark.parametrize("estimator", ["coupled", "errors", "smo", "flux", "unwrapped"])
def test_the_answer_counts_where_its_axis_is_that_of_the_estimate(c: Call, estimator: str) -> None:
    """In a blend of two angles while injection's is most of it; where there is one, always."""
    for k_s in (0.1, 0.6):
        told = k_s > 0.5 or estimator in ("coupled", "errors")
        assert answered(c, [(0.1, 0.0, 1.0)], estimator, k_s)["alarm"] == told


@pytest.mark.parametrize(
    ("share", "k_s", "load", "told"),
    [(1.3, 1.0, 0.5, False), (1.5, 1.0, 0.5, True), (1.5, 1.0, -0.5, True), (1.5, 0.9, 0.5, False),
     (1.5, 1.0, 0.05, False)],
)  # fmt: skip
def test_more_than_any_axis_answers_is_a_channel_that_reads_too_much(
    c: Call, share: float, k_s: float, load: float, told: bool
) -> None:
    """With injection alone, and not near zero current, where dead time adds to the voltage."""
    x = answered(c, [(0.2, share, 1.0)], k_s=k_s, i_q=load * MOTOR.i_rated)
    assert x["reason"] == (lib.LOCK_ANSWER if told else 0)


@pytest.mark.parametrize(
    ("load", "share", "told"), [(0.0, 0.4, False), (0.5, 0.4, True), (0.0, -0.1, True)]
)
def test_near_zero_current_dead_time_and_switches_take_their_whole_voltage(
    c: Call, load: float, share: float, told: bool
) -> None:
    """The injected voltage itself turns the current round; 0.9 V of a switch and 5.9 of 12 V."""
    motor = Motor.load("formula_wheel")
    x = answered(c, [(0.2, share, 1.0)], i_q=load * motor.i_rated, motor=motor)
    assert x["reason"] == (lib.LOCK_ANSWER if told else 0)
