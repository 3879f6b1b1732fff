"""The check on paper: what it lets through, and what it says about slips."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from sensorless.envs.scenarios.machine_family import family
from sensorless.machine.motor import MOTORS, Motor, Saturation
from sensorless.machine.rated_point import rated_point
from sensorless.suitability.examine import Examination, examine
from sensorless.suitability.finding import LIMIT, NO, NOTE, Finding, verdict

SHIPPED = sorted(path.stem for path in MOTORS.glob("*.toml"))
LINEAR = Motor.load("ipmsm_2200w")
PAPER = Motor.load("paper")


def changed(motor: Motor, **changes: Any) -> Examination:
    """A linear machine stays one with the inductances and the flux that it is given."""
    out = replace(motor, **changes)
    if motor is LINEAR:
        out = replace(out, saturation=Saturation.linear(out.L_d, out.L_q, out.psi_f))
    return examine(out, 15.0)


@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_machines_are_suitable_on_paper(name: str) -> None:
    assert examine(Motor.load(name), 15.0).verdict.word == "yes"


def test_random_machines_are_suitable() -> None:
    """Consistent by construction: a threshold that refuses them is wrong."""
    words = [examine(motor, 15.0).verdict for motor in family(1, 40)]
    assert sum(v.word == "yes" for v in words) >= 36
    assert all(v.word != "no" for v in words), [str(v) for v in words if v.word == "no"]


@pytest.mark.parametrize(
    ("changes", "word", "said"),
    [
        ({"psi_f": 8.0}, "no", "psi_f = 8"),
        ({"L_d": 36.0, "L_q": 51.0}, "no", "L_d = 36"),
        ({"L_d": 36e-6, "L_q": 51e-6}, "no", "L_d = 3.6e-05"),
        ({"J": 3.0}, "with limits", "J = 3"),
        ({"J": 150.0}, "no", "J = 150"),
        (
            {"tau_rated": 14e3},
            "no",
            "tau_rated = 14000: rated torque over that of rated current",
        ),
        ({"i_rated": 6.08e-3}, "no", "i_rated"),
        ({"L_d": 0.051, "L_q": 0.036}, "no", "swapped"),
        ({"L_d": 0.05, "L_q": 0.05}, "no", "no saliency"),
        ({"i_max": 13.0, "i_trip": 20.0}, "no", "i_max = 13 A is above what the converter"),
        ({"u_inj": 400.0}, "no", "beyond 311.8 V, the most that a DC link of 540 V"),
        ({"u_inj": 200.0}, "with limits", "above a fifth of the DC link, 108 V"),
        ({"u_inj": 3.0}, "no", "angle noise"),
        ({"R_s": 360.0}, "no", "R_s = 360"),
        ({"n_p": 30}, "no", "PWM periods per electrical turn"),
        ({"u_dc": 300.0}, "with limits", "beyond 300 V: rated torque is reached up to"),
        ({"tau_rated": 30.0}, "with limits", "rated torque 30 N m needs more than i_max"),
        ({"dead_time": 3e-5}, "with limits", "dead_time = 3e-05 s is 15% of T_s"),
        (
            {"dead_time": 1.9e-5, "u_inj": 70.0},
            "with limits",
            "70 V is below 77.8 V, which dead_time, 1.5 times the file's",
        ),
        ({"i_max": 5.0}, "with limits", "i_max = 5 A is below i_rated"),
        ({"i_max": 9e-6}, "no", "i_max = 9e-06 A is 1.5e-06 of i_rated"),
        ({"i_trip": 1.8e10}, "with limits", "i_trip = 1.8e+10 A is above 10 times i_max"),
        ({"adc_range": 5.0, "i_trip": 1e4}, "no", "i_trip = 10000 A is above 10 times i_max"),
        ({"adc_range": 5.0, "i_trip": 1e4}, "no", "is above what the converter measures, 5 A"),
        ({"B": 1e9}, "no", "B = 1e+09 N m s/rad: friction"),
        ({"L_d": 3.6e-11}, "no", "L_d = 3.6e-11"),
        ({"psi_f": 5.45e8}, "no", "psi_f = 5.45e+08"),
    ],
)
def test_slips_are_found(changes: dict[str, Any], word: str, said: str) -> None:
    e = changed(LINEAR, **changes)
    texts = [f.text for f in e.findings]
    assert e.verdict.word == word, texts
    assert any(said in text for text in texts), texts


@pytest.mark.parametrize(
    ("changes", "said"), [({"u_dc": 24.0}, "too much"), ({"n_rated_rpm": 15.0}, "too little")]
)
def test_what_all_voltages_share_is_named_once(changes: dict[str, Any], said: str) -> None:
    e = changed(LINEAR, **changes)
    heavy = [f for f in e.findings if f.weight != NOTE]
    (found,) = (f for f in heavy if f.field in ("u_dc", "psi_f", "L_d", "L_q"))
    assert found.field == "u_dc" and found.weight == NO
    assert f"all {said}: wrong DC link, rated speed or pole pairs?" in found.text


def test_inductances_that_contradict_the_flux_map() -> None:
    e = changed(PAPER, L_q=0.35)
    said = "[saturation] gives L_q = 0.286 at zero current, but the file says 0.35"
    assert said in str(e.verdict)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"i_f": 0.0}, "[saturation] has no magnet, i_f = 0, but the file says psi_f = 0.545"),
        ({"a_d0": 1e11}, "a_d0 = 1e+11 gives"),
        ({"a_d0": 150.0, "i_f": 81.75}, "[saturation] gives L_d = 0.006667 at zero current"),
    ],
)
def test_a_flux_map_of_another_machine(changes: dict[str, Any], said: str) -> None:
    e = examine(replace(LINEAR, saturation=replace(LINEAR.saturation, **changes)), 15.0)
    assert e.verdict.word == "no" and said in str(e.verdict)
    assert e.point is None or not np.isnan(e.point.top_speed)


def test_cross_coupling_beyond_a_current_asks_for_a_lower_limit() -> None:
    """A q axis that saturates suddenly turns the axes: the current from where on is named."""
    steep = replace(PAPER.saturation, a_qq=1.0, T=4)
    e = examine(replace(PAPER, saturation=steep, i_max=14.0, i_trip=60.0, adc_range=40.0), 15.0)
    (found,) = (f for f in e.findings if f.text.startswith("turn by cross-coupling"))
    assert found.weight == LIMIT
    at = float(found.text.split("above ")[1].split(" A")[0])
    assert found.text.endswith(f"above {at:.3g} A: lower i_max; needed: at most 25")
    assert e.seen is not None
    size = np.hypot(*e.seen.signal.i.T)
    assert np.interp(at, size, np.abs(e.seen.cross_deg)) == pytest.approx(25.0, abs=4.0)


def test_a_current_that_rated_torque_needs_is_no_limit_to_set() -> None:
    """Turned axes from below the current of rated torque on: a lower ``i_max`` would not do."""
    steep = replace(PAPER.saturation, a_qq=1.0, T=4)
    motor = replace(PAPER, saturation=steep, i_max=14.0, i_trip=60.0, adc_range=40.0)
    point = examine(motor, 15.0).point
    assert point is not None
    more = replace(motor, tau_rated=motor.tau_rated * 13.0 / point.current)
    (found,) = (
        f for f in examine(more, 15.0).findings if f.text.startswith("turn by cross-coupling")
    )
    assert "less than rated torque needs: rate the machine for less" in found.text


@pytest.mark.parametrize(("share", "weight"), [(0.09, None), (0.11, LIMIT), (0.6, NO)])
def test_iron_loss_over_rated_power_weighs(share: float, weight: str | None) -> None:
    power = PAPER.tau_rated * PAPER.omega_m_rated
    found = examine(replace(PAPER, p_iron=share * power), 15.0).findings
    assert [f.weight for f in found if f.field == "p_iron"] == ([weight] if weight else [])


@pytest.mark.parametrize(("ratio", "weight"), [(1.04, NO), (1.1, LIMIT), (1.2, LIMIT), (1.3, None)])
def test_weak_saliency_weighs(ratio: float, weight: str | None) -> None:
    """At every current of a linear machine: a lower ``i_max`` helps none."""
    e = changed(LINEAR, L_q=ratio * LINEAR.L_d, u_inj=108.0)
    found = [f for f in e.findings if f.text.startswith("inductance ratio")]
    assert [f.weight for f in found] == ([weight] if weight else [])
    assert all("within rated current; needed: at least 1.3" in f.text for f in found)
    assert all(("unnoticed" in f.text) == (f.weight == LIMIT) for f in found)


@pytest.mark.parametrize(("ratio", "told"), [(1.35, "4%"), (1.5, "13%"), (1.7, None)])
def test_a_small_ratio_that_no_load_was_measured_for_is_noted(
    ratio: float, told: str | None
) -> None:
    """With a flux map it is known, and with a large margin it does not matter."""
    notes = [f.text for f in changed(LINEAR, L_q=ratio * LINEAR.L_d).findings if f.field == "L_q"]
    assert [f"takes {told} of L_q" in text for text in notes if "no saturation" in text] == (
        [] if told is None else [True]
    )
    assert not any("no saturation" in f.text for f in changed(PAPER).findings)


def test_suggestions_of_the_papers_machine_lie_near_its_choices() -> None:
    e = examine(PAPER, 15.0)
    assert e.suggested is not None
    assert e.suggested["u_inj"] == pytest.approx(50.0, rel=0.1)
    assert PAPER.i_max < e.suggested["i_trip"] < PAPER.i_trip
    assert PAPER.i_max < e.suggested["adc_range"] < PAPER.adc_range
    assert e.suggested["T_s"] == PAPER.T_s


@pytest.mark.parametrize(("i_trip", "low"), [(10.0, True), (12.6, False), (18.2, False)])
def test_a_trip_that_the_current_reaches_is_said(i_trip: float, low: bool) -> None:
    """12.6 A is the suggested 13 A in two digits: who takes the suggestion has no note."""
    e = changed(LINEAR, i_trip=i_trip)
    assert e.suggested is not None and e.suggested["i_trip"] == 13.0
    texts = [f.text for f in e.findings if "before control reacts" in f.text]
    assert bool(texts) == low and e.verdict.word == "yes"
    assert not low or texts[0].startswith("i_trip = 10 A is below 13 A")


@pytest.mark.parametrize("name", SHIPPED)
def test_no_machine_needs_more_than_three_times_rated(name: str) -> None:
    """What `motor new` writes, twice its current limit, is never below the suggestion."""
    motor = Motor.load(name)
    for i_rated in (motor.i_rated, 0.8 * motor.i_rated):
        new = replace(motor, i_rated=i_rated, i_max=1.5 * i_rated, i_trip=3.0 * i_rated)
        assert not any("before control" in f.text for f in examine(new, 15.0).findings)


def test_a_short_circuit_above_the_trip_is_said() -> None:
    short = LINEAR.psi_f / LINEAR.L_d
    said = {
        i_trip: [f.weight for f in changed(LINEAR, i_trip=i_trip).findings if "shorted" in f.text]
        for i_trip in (0.99 * short, 1.01 * short)
    }
    assert list(said.values()) == [[NOTE], []]
    hub = [f.text for f in examine(Motor.load("ebike_hub"), 15.0).findings]
    assert any("about psi_f / L_d = 205.4 A, above i_trip = 100 A" in text for text in hub)


def test_the_heaviest_finding_decides() -> None:
    a, b, c = (Finding(w, "x", w) for w in (NOTE, LIMIT, NO))
    assert str(verdict([a])) == "suitable: yes"
    assert str(verdict([a, b])) == "suitable: with limits, because limit"
    assert str(verdict([c, b, a])) == "suitable: no, because no; limit"


def test_a_flux_map_without_inverse_is_a_verdict_not_an_error() -> None:
    e = examine(replace(LINEAR, saturation=Saturation(a_d0=1e-11, a_q0=1e11, i_f=1.0)), 15.0)
    assert e.verdict.word == "no"


def test_twenty_periods_a_turn_are_enough() -> None:
    """3000 r/min with five pole pairs at 5 kHz are 20, and 19.999... in binary."""
    few = [
        [
            f.text
            for f in changed(LINEAR, n_p=5, n_rated_rpm=n, T_s=2e-4).findings
            if f.field == "T_s"
        ]
        for n in (3000.0, 3001.0)
    ]
    assert few == [[], ["rated speed has 19.99 PWM periods per electrical turn; needed: 20"]]


def test_much_resistance_is_noted() -> None:
    """Voltage of rated current in R_s over the EMF: 8 % of this machine's."""
    notes = [
        [f.text for f in changed(LINEAR, R_s=R_s).findings if (f.weight, f.field) == (NOTE, "R_s")]
        for R_s in (LINEAR.R_s, 3.0 * LINEAR.R_s)
    ]
    assert not notes[0]
    (said,) = notes[1]
    assert "R_s = 10.8 ohm takes 26% of the EMF at rated speed" in said


def test_friction_that_is_a_load_limits() -> None:
    """A fan's load in B: the machine cannot drive its rated torque and that too."""
    for share, weight in ((0.25, LIMIT), (0.15, None)):
        b = share * PAPER.tau_rated / PAPER.omega_m_rated
        found = [f for f in examine(replace(PAPER, B=b), 15.0).findings if f.field == "B"]
        assert [f.weight for f in found] == ([weight] if weight else [])
        assert all("25% of rated torque" in f.text for f in found)


@pytest.mark.parametrize(("share", "asked"), [(1.0 / 1.414, True), (0.95, False)])
def test_a_rating_that_misses_by_a_mix_up_asks(share: float, asked: bool) -> None:
    """RMS for peak: the question is asked, not only the number given."""
    motor = replace(LINEAR, tau_rated=rated_point(LINEAR).torque / share)
    (text,) = (f.text for f in examine(motor, 15.0).findings if f.field == "rating")
    assert ("peak values?" in text) == asked


@pytest.mark.parametrize(("times", "weight"), [(1.6, NOTE), (1.9, NOTE), (2.1, LIMIT)])
def test_a_current_for_twice_the_torque_limits(times: float, weight: str) -> None:
    motor = replace(LINEAR, tau_rated=rated_point(LINEAR).torque / times)
    found = [f.weight for f in examine(motor, 15.0).findings if f.field == "tau_rated"]
    assert found == [weight]


@pytest.mark.parametrize(("share", "weight"), [(0.97, NO), (1.03, LIMIT)])
def test_a_link_too_low_for_rated_speed_at_any_torque_is_refused(share: float, weight: str) -> None:
    """With rated current against the magnet, psi_f - L_d i is left, and R_s i across it.

    Field weakening has 0.97 of u_dc / sqrt(3). A little more voltage makes a little torque there.
    """
    i, w = LINEAR.i_rated, LINEAR.omega_rated
    left = np.hypot(w * (LINEAR.psi_f - LINEAR.L_d * i), LINEAR.R_s * i)
    e = changed(LINEAR, u_dc=share * float(left) * np.sqrt(3.0) / 0.97, u_inj=50.0)
    assert [f.weight for f in e.findings if f.field == "rating"] == [weight]
