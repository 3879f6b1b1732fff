"""The page's initial memory: the native core's records, and where their numbers lie."""

import json

import numpy as np
import pytest

from sensorless.core.api import SIM, TABLE, lib
from sensorless.design.drive import ESTIMATORS, DriveDesign
from sensorless.machine.motor import Motor
from sensorless.policies.registry import RULES
from web.assemble import WEB
from web.fields import FIELDS, KINDS, offsets, response
from web.image import image, template
from web.rules import MOTORS, rules, without_table

NUMBERS = {kind: np.dtype(name) for name, kind in KINDS.items()}


def test_offsets_are_those_of_the_record() -> None:
    """A number written at an offset appears in its field."""
    raw = bytearray(SIM.itemsize)
    for j, (at, kind) in enumerate(offsets(SIM, FIELDS).values(), 1):
        raw[at : at + NUMBERS[kind].itemsize] = NUMBERS[kind].type(j).tobytes()
    record = np.frombuffer(bytes(raw), dtype=SIM)[0]
    for j, path in enumerate(FIELDS, 1):
        value = record
        for name in path.split("."):
            value = value[name]
        assert np.ravel(value)[0] == j, path
    with pytest.raises(KeyError):
        offsets(SIM, ("drive.gone",))


def test_records_of_the_image_are_the_native_ones() -> None:
    data, text = image()
    layout = json.loads(text)
    assert [m["name"] for m in layout["motors"]] == list(MOTORS)
    for told in layout["motors"][:2]:
        motor = Motor.load(told["name"])
        assert set(told["sims"]) == set(ESTIMATORS)
        at = told["sims"]["flux"]
        assert data[at : at + SIM.itemsize] == template(motor, "flux").tobytes()
        for rule, named in zip(told["rules"], rules(motor), strict=True):
            header = np.frombuffer(data, TABLE, 1, rule["at"])[0]
            stored = np.frombuffer(data, np.float32, int(header["n_nodes"]), rule["values"])
            assert np.array_equal(stored, named.policy.table.values.ravel()), named.word


def test_the_page_takes_the_cores_own_numbers() -> None:
    layout = json.loads(image()[1])
    assert next(iter(layout["estimators"])) == DriveDesign().estimator
    assert layout["most_nodes"] == lib.KS_TABLE_NODES


def test_the_form_asks_for_seeds_that_exist() -> None:
    page = (WEB / "page.html").read_text(encoding="utf-8")
    last = len(json.loads(image()[1])["seeds"]) - 1
    assert f"noise, 0 to {last}<" in page
    assert f'max="{last}"' in page


def test_faults_are_single_bits_in_words() -> None:
    layout = json.loads(image()[1])
    for bits in (layout["faults"], layout["lost"]):
        assert all(int(bit) & (int(bit) - 1) == 0 for bit in bits)
    assert layout["faults"]["1"] == "a current sample was not plausible"


def test_every_lever_moves_the_machine(motor: Motor) -> None:
    (told,) = (m for m in json.loads(image()[1])["motors"] if m["name"] == motor.name)
    known = {at: path for path, (at, _) in offsets(SIM, ("plant.R_s", "plant.inv_J")).items()}
    ((resistance, *_),), ((inertia, *_),) = (told["levers"][x] for x in ("resistance", "inertia"))
    assert (known[resistance], known[inertia]) == ("plant.R_s", "plant.inv_J")
    assert told["levers"]["inertia"][0][2] == "over"
    assert len(told["levers"]["magnet"]) == 1


def test_what_cannot_be_scaled_is_refused(motor: Motor) -> None:
    base = template(motor, "coupled")
    other = base.copy()
    other["plant"]["R_s"] += 1.0
    with pytest.raises(ValueError, match=r"plant\.R_s"):
        response(base[0], other[0])


def test_learned_tables_are_offered_only_for_their_machine(motor: Motor) -> None:
    assert "reference" in {rule.word for rule in rules(motor)}
    words = {rule.word for rule in rules(Motor.load("ipmsm_2200w"))}
    assert "eq25" in words
    assert not {"reference", "linear-coupled-tuned"} & words


def test_every_rule_is_offered_or_named_as_missing(motor: Motor) -> None:
    """But for bounds, and those whose numbers come from tuning or under another name."""
    offered = {rule.word.partition(":")[0] for rule in rules(motor)}
    missing = set(json.loads(image()[1])["untabled"])
    assert missing == set(without_table(motor)) >= {"hysteresis", "ramp", "gated", "fusion"}
    assert not offered & missing
    elsewhere = {"linear", "logistic", "grid", "hfi", "smo", "oracle", "sensored"}
    assert set(RULES) - offered - missing <= elsewhere
