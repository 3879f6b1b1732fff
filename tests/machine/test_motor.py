"""Machine files: what is read, what is refused and how, and that every number has its source."""

import os
import re
import sys
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import pytest

from sensorless.errors import LONGEST, UserError
from sensorless.machine.motor import MOTORS, Motor, Saturation
from sensorless.machine.motor_file import check_motor_out, toml_value

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

SHIPPED = sorted(MOTORS.glob("*.toml"))
PAPER = (MOTORS / "paper.toml").read_text(encoding="utf-8")
HUGE = "1" + "0" * 400
TABLES = ("machine", "rating", "drive")


def write(folder: Path, text: str) -> Path:
    path = folder / "mine.toml"
    path.write_text(text, encoding="utf-8")
    return path


def change(field: str, value: str) -> str:
    """The paper's motor with another value of one field."""
    text, n = re.subn(rf"(?m)^{field} = [^#\n\"]+", f"{field} = {value} ", PAPER, count=1)
    assert n == 1, field
    return text


def refusal(path: Path) -> str:
    with pytest.raises(UserError) as error:
        Motor.load(path)
    message = str(error.value)
    assert "\n" not in message
    assert str(path) in message
    return message


def numbers() -> list[str]:
    data = tomllib.loads(PAPER)
    return [name for table in TABLES for name in data[table]]


def test_paper_motor() -> None:
    """Table 1 of the source paper."""
    motor = Motor.load("paper")
    assert (motor.n_p, motor.R_s, motor.L_d, motor.L_q, motor.psi_f) == (
        2,
        2.484,
        0.063,
        0.286,
        0.993,
    )
    assert (motor.J, motor.T_s, motor.u_inj, motor.n_rated_rpm) == (0.02, 2e-4, 50.0, 1500.0)
    assert motor.omega_rated == pytest.approx(314.159, abs=1e-3)
    assert motor.rpm_to_electrical(300.0) == pytest.approx(62.832, abs=1e-3)


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_shipped_motors_load(path: Path) -> None:
    """By name and by path, to the same machine, named like its file."""
    assert Motor.load(path.stem) == Motor.load(path)
    assert Motor.load(path).name == path.stem


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_every_number_has_a_source(path: Path) -> None:
    """Each field of each table, and the saturation as a whole; no source for what is not there."""
    data = tomllib.loads(path.read_text(encoding="utf-8"))
    named = {name for table in TABLES for name in data[table]}
    named |= {"saturation"} if "saturation" in data else set()
    source = data["source"]
    assert set(source) == named
    assert all(isinstance(text, str) and len(text) >= 5 for text in source.values())


@pytest.mark.parametrize("field", numbers())
def test_missing_field(field: str, tmp_path: Path) -> None:
    """The message names the field and what it is."""
    text = re.sub(rf"(?m)^{field} = [^\"\n]+$", "", PAPER, count=1)
    assert f" {field}: missing" in refusal(write(tmp_path, text))


@pytest.mark.parametrize("value", ["-1.5", "nan", "inf", "-inf", '"much"', "true", "[1.0]", HUGE])
def test_bad_value(value: str, tmp_path: Path) -> None:
    """Negative, not a number, infinite, no number at all: field, value and what it must be."""
    for field in numbers():
        message = refusal(write(tmp_path, change(field, value)))
        assert f" {field}: " in message
        assert ": must be " in message
        assert value.strip('"-')[: LONGEST // 2] in message or (
            value == "true" and "True" in message
        )
        assert len(message) < len(str(tmp_path)) + 4 * LONGEST


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("L_d", "1e-300"),
        ("T_s", "1e-300"),
        ("n_p", "2.5"),
        ("n_p", "0"),
        ("adc_bits", "3"),
        ("T_s", "0.5"),
        ("R_s", "0.0"),
        ("L_d", "0"),
    ],
)
def test_out_of_range(field: str, value: str, tmp_path: Path) -> None:
    """Whole numbers are whole, and a machine has resistance and inductance."""
    assert f" {field}: {float(value) if '.' in value else value}" in refusal(
        write(tmp_path, change(field, value))
    )


@pytest.mark.parametrize(
    ("text", "name"),
    [
        (PAPER.replace("[machine]", "[machine]\nL_s = 0.1"), "L_s"),
        (PAPER.replace("[saturation]", "[saturation]\nX = 1"), "X"),
        ("colour = 3\n" + PAPER, "colour"),
    ],
)
def test_unknown_field(text: str, name: str, tmp_path: Path) -> None:
    """A field nobody reads is a mistake, not a comment."""
    assert f" {name}: unknown: use only " in refusal(write(tmp_path, text))


def test_unknown_table(tmp_path: Path) -> None:
    said = refusal(write(tmp_path, PAPER.replace("[drive]", "[drives]")))
    assert "[drives]: unknown table; choose from [machine], [rating], [drive]" in said


@pytest.mark.parametrize(
    ("field", "value"),
    [("S", "9"), ("T", "1.5"), ("a_dq", "-3.0"), ("a_d0", "0.0"), ("i_f", "nan")],
)
def test_bad_saturation(field: str, value: str, tmp_path: Path) -> None:
    """Exponents are whole numbers up to 7, coefficients not negative."""
    text = re.sub(rf"(?m)^{field} = .*$", f"{field} = {value}", PAPER, count=1)
    assert f"saturation: {field}: " in refusal(write(tmp_path, text))


def test_trip_has_to_lie_above_the_limit(tmp_path: Path) -> None:
    """Two fields that contradict each other."""
    assert "i_trip: 6.5 A: must be above i_max = 6.8 A" in refusal(
        write(tmp_path, change("i_trip", "6.5"))
    )


NESTED = b"x = " + b"[" * 100_000
DIGITS = b"n_p = 1" + b"0" * 5000
HEX = PAPER.encode().replace(b"n_p = 2\n", b"n_p = 0x" + b"f" * 5000 + b"\n")
"""A whole number that TOML allows and Python does not write."""


@pytest.mark.parametrize(
    "content",
    [b"n_p = = 2", b"\xff\xfe\x00", b"[machine", b"name = 3", NESTED, DIGITS, HEX],
    ids=["syntax", "text", "cut off", "type", "nested", "digits", "hex"],
)
def test_not_a_motor_file(content: bytes, tmp_path: Path) -> None:
    """Broken TOML and broken text are one line as well."""
    path = tmp_path / "mine.toml"
    path.write_bytes(content)
    refusal(path)


def test_another_encoding_is_told(tmp_path: Path) -> None:
    """PowerShell writes UTF-16, which TOML does not allow."""
    path = tmp_path / "mine.toml"
    path.write_text(PAPER, encoding="utf-16")
    assert "not in UTF-8; save it as UTF-8" in refusal(path)


@pytest.mark.parametrize("character", ["\\n", "\\u001b", "\\u202e"])
def test_a_name_with_control_characters_is_refused(character: str, tmp_path: Path) -> None:
    """Such a name would break lines of reports and of exported code."""
    text = PAPER.replace('name = "paper"', f'name = "a{character}b"')
    assert "leave out control characters" in refusal(write(tmp_path, text))


def test_unknown_name_lists_the_known() -> None:
    """A typing error in the name shows what there is."""
    with pytest.raises(UserError, match=r"motor 'papre'.*mean paper\? shipped motors: .*paper"):
        Motor.load("papre")
    with pytest.raises(UserError, match=r"motor '\.': a folder: give a \.toml file; shipped"):
        Motor.load(".")


def test_a_file_with_a_byte_order_mark_is_read(tmp_path: Path) -> None:
    """Editors on Windows begin a file with it."""
    path = tmp_path / "mine.toml"
    path.write_text(PAPER, encoding="utf-8-sig")
    assert Motor.load(path) == Motor.load("paper")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no named pipes on this system")
def test_a_pipe_is_no_regular_file(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "mine.toml")
    assert "no regular file: give a .toml file" in refusal(tmp_path / "mine.toml")


def test_without_saturation_the_machine_is_linear(tmp_path: Path) -> None:
    """The table is optional."""
    text = re.sub(r"(?ms)^\[saturation\].*?(?=^\[drive\])", "", PAPER)
    motor = Motor.load(write(tmp_path, text))
    assert motor.saturation == Saturation.linear(motor.L_d, motor.L_q, motor.psi_f)


def other_value(value: Any) -> Any:
    if isinstance(value, bool):
        return not value
    return 1.0 if value is None else value + 1 if isinstance(value, (int, float)) else value


@pytest.mark.parametrize(
    "name", [f.name for f in fields(Motor) if f.name not in ("name", "description", "saturation")]
)
def test_digest_sees_every_number(name: str) -> None:
    """Two machines that differ in one number have different digests; the description has no say."""
    motor = Motor.load("paper")
    assert replace(motor, **{name: other_value(getattr(motor, name))}).digest != motor.digest
    assert replace(motor, description="other words").digest == motor.digest


@pytest.mark.parametrize("name", [f.name for f in fields(Saturation)])
def test_digest_sees_the_saturation(name: str) -> None:
    """Also every coefficient of the flux map counts."""
    motor = Motor.load("paper")
    other = replace(motor.saturation, **{name: other_value(getattr(motor.saturation, name))})
    assert replace(motor, saturation=other).digest != motor.digest


def test_a_text_of_any_bytes_is_read_back() -> None:
    for text in ('a "b" \\ c\nd', "m\u00e9", "\x00\x1f\x7f", "bad\udcff"):
        read = tomllib.loads(f"name = {toml_value(text)}")["name"]
        assert read == text.replace("\udcff", "?")


def test_a_motor_file_is_read_and_written_as_toml_alone(tmp_path: Path) -> None:
    bare = tmp_path / "mine"
    bare.write_text((MOTORS / "paper.toml").read_text(encoding="utf-8"), encoding="utf-8")
    with pytest.raises(UserError, match=r"mine': the name of a motor file ends in \.toml"):
        Motor.load(bare)
    for name in ("mine", "mine.TOML", "mine.csv"):
        with pytest.raises(UserError, match=r"the name of a motor file ends in \.toml"):
            check_motor_out(tmp_path / name)
    check_motor_out(tmp_path / "mine.toml")
    check_motor_out(None)
