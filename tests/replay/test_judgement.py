"""What is said of the estimators over a log: the best, the causes, and dead reckoning."""

from dataclasses import replace

import numpy as np
import pytest

from sensorless.replay.judgement import judgement
from sensorless.replay.replay import Estimate, Replay
from tests.helpers.sample import replayed_sample


@pytest.fixture(scope="module")
def found() -> Replay:
    return replayed_sample()


def off(found: Replay, name: str, degrees: float, scatter: float, own: float = 1.0) -> Replay:
    """With an estimator that is off by so much, and has a signal in the last share of samples."""
    assert found.log.theta_e is not None
    n = len(found.log.t)
    turn = np.radians(degrees + scatter * np.where(np.arange(n) % 2, 1.0, -1.0))
    made = Estimate(found.log.theta_e - turn, np.zeros(n), np.arange(n) >= (1.0 - own) * n)
    return replace(found, estimates=found.estimates | {name: made})


def test_constant_errors_and_scatter_have_their_causes(found: Replay) -> None:
    lines = judgement(off(off(found, "hfi", 8.0, 1.0), "ekf", 1.0, 9.0))
    assert lines[0].startswith("best here: flux alone, 0.8")
    hfi, ekf = (next(line for line in lines if line.startswith(name)) for name in ("HFI", "EKF"))
    assert "8.00° constant and 1.00° scatter" in hfi and "identify cross-coupling" in hfi
    assert "1.00° constant and 9.00° scatter" in ekf and "transients" in ekf


@pytest.mark.parametrize(("way", "said"), [(-1.0, "ahead of"), (1.0, "behind")])
def test_an_error_that_all_share_is_the_encoders(found: Replay, way: float, said: str) -> None:
    assert not any("all estimators" in line for line in judgement(found))
    turned = found
    for k, name in enumerate(found.estimates):
        turned = off(turned, name, way * (18.0 + k), 2.0)
    assert f"are 20° {said} the encoder" in judgement(turned)[1]
    assert not any("all estimators" in x for x in judgement(off(turned, "hfi", 0.0, 2.0)))


@pytest.mark.parametrize(
    ("errors", "own"),
    [
        ((3.0, 3.0, 3.0, 3.0), 1.0),  # too small
        ((8.0, 20.0, 20.0, 20.0), 1.0),  # not alike
        ((20.0, 20.0, 20.0, 20.0), 0.1),  # observers alone share causes
    ],
)
def test_other_errors_are_not_the_encoders(
    found: Replay, errors: tuple[float, ...], own: float
) -> None:
    for name, error in zip(("hfi", "smo", "blend", "ekf"), errors, strict=True):
        found = off(found, name, error, 1.0, own if name == "hfi" else 1.0)
    assert not any("all estimators" in line for line in judgement(found))


def test_only_what_is_a_tenth_worse_than_the_best_is_explained(found: Replay) -> None:
    for name, scatter in (("hfi", 1.0), ("smo", 1.08), ("blend", 1.08), ("ekf", 1.15)):
        found = off(found, name, 0.0, scatter)
    lines = judgement(found)
    assert len(lines) == 2 and lines[0].startswith("best here: HFI, 1.00")
    assert lines[1].startswith("EKF: 1.15")


def test_where_none_follows_no_cause_is_guessed(found: Replay) -> None:
    for name in found.estimates:
        found = off(found, name, 80.0, 0.0)
    (said,) = judgement(found)
    assert "no estimator follows the encoder" in said and "80° RMS" in said and "delay" in said


def test_a_log_that_contradicts_itself_is_not_judged(found: Replay) -> None:
    (said,) = judgement(replace(found, log=replace(found.log, doubtful=True)))
    assert "the log contradicts itself" in said


def test_dead_reckoning_counts_apart(found: Replay) -> None:
    """Half of the samples without a signal and 40 degrees off: not an error of the estimator."""
    made = off(found, "blend", 40.0, 0.0, own=0.5)
    row = made.summary()["blend"]
    assert row["share"] == pytest.approx(0.5) and row["without_rms_deg"] == pytest.approx(40.0)
    said = judgement(made)[-1]
    assert said.startswith("dead reckoning: in 50 % of the samples") and "40.0° RMS" in said


@pytest.mark.parametrize(("own", "said"), [(0.97, "in 3 % of the samples"), (0.995, "")])
def test_a_moment_without_a_signal_is_not_worth_a_word(
    found: Replay, own: float, said: str
) -> None:
    lines = [x for x in judgement(off(found, "blend", 5.0, 0.0, own)) if "dead reckoning" in x]
    assert len(lines) == (said != "") and all(said in line for line in lines)


def test_without_an_encoder_nothing_is_said(found: Replay) -> None:
    assert judgement(replace(found, log=replace(found.log, theta_e=None))) == []


def test_a_log_in_which_none_has_a_signal_says_so(found: Replay) -> None:
    for name in found.estimates:
        found = off(found, name, 0.0, 0.0, own=0.1)
    (said,) = judgement(found)
    assert "no estimator had a signal" in said and "--speed and --angle" in said
    assert judgement(replace(found, log=replace(found.log, theta_e=None))) == []
