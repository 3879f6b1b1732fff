"""Simulation, README and params.h agree on whether a machine's drive can find its rotor."""

import re
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from sensorless.core.api import lib
from sensorless.core.machine import COMMAND, commission_run
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import Scenarios, SimFactory
from sensorless.envs.scenarios.words import plan_from
from sensorless.errors import UserError
from sensorless.evaluation.trace import trace
from sensorless.export.export import export, table_of
from sensorless.export.start import start_text
from sensorless.machine.motor import Motor
from sensorless.observers.start_design import spin_speed
from sensorless.policies.registry import make_policy
from sensorless.units import wrapped


def starts(motor: Motor, spin: float = 0.0) -> bool:
    """Whether ``simulate --start --spin`` runs from a speed [r/min]."""
    plan = plan_from("0:100", "0:0", None, 0.1, motor, 0, start=True, spin=spin)
    try:
        trace(make_policy("eq25", motor), plan, motor, DriveDesign())
    except UserError as error:
        assert "look alike" in str(error)
        return False
    return True


@pytest.mark.usefixtures("without_selftest")
@pytest.mark.skipif(shutil.which("gcc") is None, reason="needs gcc")
@pytest.mark.parametrize(("name", "finds"), [("ipmsm_2200w", False), ("pmsyrm_5600w", True)])
def test_all_files_say_the_same(name: str, finds: bool, tmp_path: Path) -> None:
    motor = Motor.load(name)
    policy = make_policy("eq25", motor)
    folder = tmp_path / "out"
    export(table_of(policy, "eq25"), motor, DriveDesign(), folder, policy="eq25", fit=False)
    readme = (folder / "README.md").read_text(encoding="utf-8")
    params = (folder / "params.h").read_text(encoding="utf-8")
    assert starts(motor) is finds
    assert starts(motor, spin_speed(motor) + 1.0)
    assert f"#define DRIVE_FINDS_ROTOR {int(finds)} " in params
    code = re.findall(r"```c\n(.*?)```", readme, re.DOTALL)[0]
    assert ("drive_find_rotor(&drive)" in code) is finds
    assert ("cannot find the rotor" in readme) is not finds
    assert ("starts anew, but on a guessed pole" in readme) is not finds
    numbers = (folder / "params.c").read_text(encoding="utf-8")
    pulse = re.search(r"\.u_pulse = ([\d.e+-]+)f", numbers)
    assert pulse is not None and (float(pulse[1]) > 0.0) is finds
    head, rest = code.split("\n", 1)
    stubs = """
float adc_current_a(void); float adc_current_b(void); float adc_dc_link(void);
float speed_reference(void); void pwm_set_next(ab_t u, float u_dc); void report(int a, int b);
void bridge_off(void);
float known_angle(void); float known_speed(void);
void control_start(void); void control_isr(void);
"""
    (tmp_path / "isr.c").write_text(f"{head}\n{stubs}{rest}", encoding="utf-8")
    flags = ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror"]
    compile_it = ["gcc", *flags, "-fsyntax-only", f"-I{folder}", str(tmp_path / "isr.c")]
    subprocess.run(compile_it, check=True)


@pytest.mark.parametrize("name", ["ipmsm_2200w", "pmsrm_15kw", "brusa_hsm1", "formula_wheel"])
def test_the_supply_of_the_text_aligns_a_free_shaft(name: str) -> None:
    """From any angle, also from where either place would balance the rotor."""
    motor = Motor.load(name)
    text = start_text(motor)
    told = re.search(r"a supply of ([\d.]+) V", text)
    assert told is not None
    volt = float(told[1])
    ideal = replace(motor, u_transistor=0.0, u_diode=0.0)
    steps = np.zeros(2, dtype=COMMAND)
    steps["n"], steps["theta"] = round(2.0 / motor.T_s), (2.0 * np.pi / 3.0, 0.0)
    steps["from"] = steps["to"] = volt / 1.5  # two phases in parallel behind one
    for k in range(12):
        s = Scenarios.nominal(ideal, np.array([1], np.uint64), 1.0)
        s.dead_time[:], s.theta_0[:] = 0.0, np.pi * k / 6.0
        sim = SimFactory(ideal, DriveDesign()).build(s, twin=False)
        commission_run(sim, steps, motor.i_trip)
        theta = float(sim["drive"]["y"]["theta_e"][0])
        assert abs(wrapped(np.array(theta))) < np.radians(5.0), k


def test_the_fault_bit_of_the_text_is_the_cores() -> None:
    assert lib.FAULT_POLE == 8
