"""Datasheets to machine numbers: units, kinds, and contradictions that are named."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest

from sensorless.errors import UserError
from sensorless.machine.datasheet import (
    Datasheet,
    check_number,
    inertia_from,
    machine_numbers,
)

SHEET = Datasheet(
    poles=8, speed_rpm=3000.0, current_rms=3.6, R=1.6, ke=40.0, L_d=0.011, L_q=0.017, torque=2.4
)


def values(sheet: Datasheet) -> dict[str, float]:
    return {name: number.value for name, number in machine_numbers(sheet).items()}


def test_a_star_between_two_terminals() -> None:
    """psi_f: 40 V RMS line to line at 1000 r/min is 32.66 V peak a phase at 418.88 rad/s."""
    v = values(SHEET)
    assert (v["n_p"], v["R_s"], v["L_d"], v["L_q"]) == (4, 0.8, 0.0055, 0.0085)
    assert v["psi_f"] == pytest.approx(40.0 * math.sqrt(2.0 / 3.0) / (4 * 1000 * math.pi / 30))
    assert v["i_rated"] == pytest.approx(5.0912, abs=1e-4)


def test_peak_voltage_phase_values_and_average_inductance() -> None:
    v = values(
        replace(SHEET, ke_kind="peak", between="phase", L_d=None, L_q=None, L=9e-3, ratio=2.0)
    )
    assert v["psi_f"] == pytest.approx(40.0 / math.sqrt(3.0) / (4 * 1000 * math.pi / 30))
    assert [v["R_s"], v["L_d"], v["L_q"]] == pytest.approx([1.6, 6e-3, 12e-3])


def test_an_average_inductance_between_two_terminals_is_that_of_two_phases() -> None:
    v = values(replace(SHEET, L_d=None, L_q=None, L=9e-3, ratio=2.0))
    assert [v["L_d"], v["L_q"]] == pytest.approx([3e-3, 6e-3])


def test_kt_alone_and_its_tie_to_ke() -> None:
    """In SI, Kt per peak ampere is 1.5 times Ke as peak phase volts by mechanical rad/s."""
    v = values(replace(SHEET, ke=None, kt=0.6))
    assert v["psi_f"] == pytest.approx(0.6 / math.sqrt(2.0) / (1.5 * 4))
    both = values(replace(SHEET, kt=1.5 * 4 * values(SHEET)["psi_f"] * math.sqrt(2.0)))
    assert both == values(SHEET)


def test_kt_may_have_the_torque_of_reluctance_in_it() -> None:
    """1.5 n_p (psi + D i_q sin) i: the most over all angles of 100 A is what Kt says."""
    sheet = replace(
        SHEET, between="phase", L_d=1.2e-3, L_q=2.6e-3, current_rms=70.7, torque=110.0, ke=71.8
    )
    from_ke = values(sheet)
    assert values(replace(sheet, kt=1.556)) == from_ke, "beside Ke either may agree"
    v = values(replace(sheet, ke=None, kt=1.556))
    beta = np.linspace(0.0, np.pi / 2, 100_001)
    i = v["i_rated"]
    torque = 6.0 * (v["psi_f"] + 1.4e-3 * i * np.sin(beta)) * i * np.cos(beta)
    assert torque.max() == pytest.approx(1.556 * 70.7, rel=1e-4)
    assert v["psi_f"] == pytest.approx(from_ke["psi_f"], rel=0.02)
    magnet = values(replace(sheet, ke=None, kt=1.2))["psi_f"]
    assert magnet == pytest.approx(1.2 / math.sqrt(2.0) / 6.0), "not torque over current"


def test_a_reluctance_that_makes_more_than_kt_leaves_it_to_the_magnet() -> None:
    """D i / 2 = 0.05 H 5.09 A is the flux that reluctance alone stands for; Kt says 0.079 Vs."""
    sheet = replace(SHEET, between="phase", L_d=0.01, L_q=0.11, ke=None, kt=2.4 / 3.6)
    found = machine_numbers(sheet)["psi_f"]
    assert found.value == pytest.approx(2.4 / 3.6 / math.sqrt(2.0) / 6.0)
    assert "taken as the magnet's alone" in found.source


def test_the_source_of_ke_says_what_kt_gives() -> None:
    """0.7 N m per RMS ampere is 0.7 / sqrt(2) / (1.5 4) = 0.0825 Vs, without reluctance."""
    sheet = replace(SHEET, L_q=SHEET.L_d, kt=0.7)
    assert machine_numbers(sheet)["psi_f"].source.endswith("; Kt gives 0.0825 Vs")


@pytest.mark.parametrize(
    ("name", "within", "beyond"),
    [("poles", (2.0, 200.0), (0.0, 202.0)), ("pwm", (1000.0, 1e6), (999.0, 1.001e6))],
)
def test_limits_of_a_number(
    name: str, within: tuple[float, float], beyond: tuple[float, float]
) -> None:
    for value in within:
        check_number(name, value)
    for value in beyond:
        with pytest.raises(UserError, match=re.escape(f"{name}: {value:g}")):
            check_number(name, value)


def test_power_instead_of_torque() -> None:
    assert values(replace(SHEET, torque=None, power=754.0))["tau_rated"] == pytest.approx(
        2.4, rel=1e-3
    )
    assert values(replace(SHEET, power=750.0))["tau_rated"] == 2.4


@pytest.mark.parametrize(
    ("text", "kg_m2"),
    [("320 g cm2", 3.2e-5), ("1.6kg cm²", 1.6e-4), ("1.2e-4 kg·m^2", 1.2e-4),
     ("2 g m2", 2e-3)],
)  # fmt: skip
def test_inertia_has_its_unit(text: str, kg_m2: float) -> None:
    assert inertia_from(text) == pytest.approx(kg_m2)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"kt": 1.6}, ["Ke = 40 V/krpm", "Kt = 1.6 N m/A", "0.07797 Vs", "0.1879 Vs"]),
        ({"kt": 0.936}, ["RMS and peak"]),
        ({"power": 1500.0}, ["1500 W at 3000 r/min is 4.775 N m", "2.4 N m"]),
        ({"torque": None}, ["power, torque: none given"]),
        ({"ke": None}, ["ke, kt: none given"]),
        ({"L_q": None}, ["inductance: incomplete"]),
        ({"L_d": None, "L_q": None, "L": 0.01}, ["inductance: incomplete"]),
        ({"L_d": None, "L_q": None, "ratio": 1.5}, ["inductance: incomplete"]),
        ({"L": 0.01}, ["one of the two pairs"]),
        ({"ratio": 1.5}, ["one of the two pairs"]),
        ({"L_q": None, "L": 0.01, "ratio": 1.5}, ["inductance: incomplete"]),
        ({"L_d": None, "L": 0.01, "ratio": 1.5}, ["inductance: incomplete"]),
        ({"kt_kind": "mean"}, ["kt-kind: 'mean'"]),
        ({"poles": 7}, ["poles: 7"]),
        ({"ke_kind": "mean"}, ["ke-kind: 'mean'"]),
        ({"between": "delta"}, ["between: 'delta'"]),
    ],
)
def test_contradictions_and_gaps_are_named(changes: dict[str, object], said: list[str]) -> None:
    with pytest.raises(UserError) as error:
        machine_numbers(replace(SHEET, **changes))  # type: ignore[arg-type]
    assert all(part in str(error.value) for part in said), str(error.value)


@pytest.mark.parametrize("text", ["3 oz in s2", "5", "kg m2"])
def test_inertia_without_a_known_unit(text: str) -> None:
    """A wheel of 5 kg cm2 is not one of 5 kg m2."""
    with pytest.raises(UserError, match=rf"inertia: '{text}'; give a number .* its unit.*gcm2"):
        inertia_from(text)


@pytest.mark.parametrize(("name", "said"), [("ke", True), ("kt", True), ("r", False)])
def test_a_machine_without_magnets_is_refused_in_words(name: str, said: bool) -> None:
    with pytest.raises(UserError, match="finite number above 0") as error:
        check_number(name, 0.0)
    assert ("without magnets" in str(error.value)) == said


@pytest.mark.parametrize(
    ("factor", "agrees"), [(1.13, True), (1.17, False), (0.87, True), (0.83, False)]
)
def test_ke_and_kt_may_differ_by_15_percent(factor: float, agrees: bool) -> None:
    """On a machine without reluctance, where Kt is the magnet's alone whatever it counts."""
    surface = replace(SHEET, L_d=0.011, L_q=0.011)
    kt = factor * 1.5 * 4 * values(surface)["psi_f"] / math.sqrt(0.5)
    # newton metres per peak ampere are 1 / sqrt(2) of those per RMS ampere
    for sheet in (
        replace(surface, kt=kt),
        replace(surface, kt=kt / math.sqrt(2.0), kt_kind="peak"),
    ):
        if agrees:
            assert values(sheet) == values(surface), "Ke counts"
            continue
        with pytest.raises(UserError, match=f"{factor:.3g} times as much"):
            values(sheet)


@pytest.mark.parametrize(
    ("factor", "agrees"), [(1.04, True), (1.07, False), (0.96, True), (0.93, False)]
)
def test_power_and_torque_may_differ_by_5_percent(factor: float, agrees: bool) -> None:
    sheet = replace(SHEET, power=factor * 2.4 * 3000.0 * math.pi / 30.0)
    if agrees:
        assert values(sheet)["tau_rated"] == 2.4
        return
    with pytest.raises(UserError, match="power, torque: "):
        values(sheet)


@pytest.mark.parametrize("kind", ["rms", "peak"])
@pytest.mark.parametrize(("factor", "rated"), [(1.04, True), (1.07, False)])
def test_kt_within_5_percent_of_torque_over_current_has_reluctance(
    kind: str, factor: float, rated: bool
) -> None:
    """The magnet's flux is then less than what would make that torque alone."""
    amperes = SHEET.current_rms * (1.0 if kind == "rms" else math.sqrt(2.0))
    kt = factor * 2.4 / amperes
    alone = factor * 2.4 / (1.5 * 4 * math.sqrt(2.0) * SHEET.current_rms)
    psi_f = values(replace(SHEET, ke=None, kt=kt, kt_kind=kind))["psi_f"]
    assert psi_f < 0.999 * alone if rated else psi_f == pytest.approx(alone)


@pytest.mark.parametrize("off", [2.0, 3.0, 6.0])
def test_the_mix_up_that_explains_a_contradiction_is_asked_for(off: float) -> None:
    """Root two for RMS and peak, root three for line and phase, either way; both make root six."""
    words = {2.0: "(RMS and peak", 3.0: "(line and phase", 6.0: "(both RMS with peak and line"}
    surface = replace(SHEET, L_d=0.011, L_q=0.011)
    right = 1.5 * 4 * values(surface)["psi_f"] * math.sqrt(2.0)  # per RMS ampere
    for factor in (math.sqrt(off), 1.0 / math.sqrt(off)):
        with pytest.raises(UserError, match=re.escape(words[off])):
            values(replace(surface, kt=factor * right))
