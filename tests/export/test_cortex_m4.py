"""The bare example on a host: dead time of TIM1, current range, and when the bridge opens."""

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from sensorless.export.code import params_header
from sensorless.export.export import Exported
from sensorless.machine.motor import Motor

pytestmark = pytest.mark.skipif(shutil.which("gcc") is None, reason="needs gcc")

RIG = r"""
#include <math.h>
#include <stdio.h>
#define main example_main
#include "example/cortex_m4.c"
#undef main

int main(void) {
    for (unsigned steps = 1; steps <= 1008u; steps++) {
        printf("code %u %u\n", steps, (unsigned)DEAD_TIME_CODE(steps));
    }
    timer();
    printf("register %u\n", (unsigned)TIM1_BDTR);
    printf("range %.9g\n", (double)(2048.0f * AMPERES_PER_STEP));
    printf("link %.9g\n", (double)(4096.0f * VOLTS_PER_STEP));
    converter();
    printf("clock %u\n", (unsigned)ADC_CCR);
    float limits[] = {0.5f * drive_params.guard.u_dc_min, drive_params.guard.u_dc_max};
    float links[] = {0.999f * limits[0], limits[0], limits[1], 1.001f * limits[1], 0.0f, NAN};
    for (int j = 0; j < 6; j++) {
        ab_t u = {0.2f * limits[0], 0.0f};
        pwm_set_next(u, links[j]);
        double apart = ((double)TIM1_CCR(0) - (double)TIM1_CCR(1)) / (double)TIM1_ARR;
        printf("duty %d %.9g\n", j, j < 5 ? apart * (double)links[j] / (double)limits[0] : apart);
    }
    int faults[] = {0, FAULT_LOCK, FAULT_OVER_CURRENT, FAULT_STOPPED};
    control_start();
    drive.start.phase = START_DONE;
    for (int j = 0; j < 4; j++) {
        offset_samples = 1024;
        mode = MODE_RUN;
        bridge_on();
        drive.fault = faults[j];
        adc_interrupt();
        printf("bridge %d %d\n", faults[j], (TIM1_BDTR & 1u << 15) != 0);
    }
    restart = 1;
    adc_interrupt();
    printf("again %d %d %d\n", mode == MODE_RUN, (TIM1_BDTR & 1u << 15) != 0, drive.fault);
    for (int broken = 0; broken < 2; broken++) { /* a check that fails, or that a break ends */
        bring_up_init(&check);
        check.phase = broken ? check.phase : BRING_UP_DONE;
        check.fault = BRING_UP_FAULT_SIGN;
        TIM1_SR = broken ? 1u << 7 : 0u;
        mode = MODE_CHECK;
        reported = 0;
        bridge_on();
        for (restart = 0; restart < 2; restart++) {
            adc_interrupt();
            printf("failed %d %d %d %d\n", mode == MODE_FAILED, (TIM1_BDTR & 1u << 15) != 0,
                   wrong == BRING_UP_FAULT_SIGN, reported);
        }
    }
    return 0;
}
"""


def run(folder: Path) -> str:
    """Run the example with registers in an array; what the rig prints."""
    example = folder / "example" / "cortex_m4.c"
    text, n = re.subn(
        r"#define REG\(address\) .*",
        "static volatile uint32_t regs[1 << 16];\n"
        "#define REG(address) regs[((address) & 0x3FFFFu) >> 2]",
        example.read_text(),
    )
    assert n == 1
    example.write_text(text)
    (folder / "rig.c").write_text(RIG)
    words = ["gcc", "-std=c99", "-O1", "-I.", "-o", "rig", "rig.c", "params.c", "ks_table_data.c"]
    core = map(str, (folder / "core").glob("*.c"))
    subprocess.run([*words, *core], cwd=folder, check=True)
    return subprocess.run(["./rig"], cwd=folder, capture_output=True, text=True, check=True).stdout


def inserted(code: int) -> int:
    """Steps of dead time for DTG[7:0], by the register's description in RM0090."""
    if code < 0x80:
        return code
    if code < 0xC0:
        return (64 + (code & 63)) * 2
    return (32 + (code & 31)) * (8 if code < 0xE0 else 16)


def test_dead_time_range_and_bridge(copied: Path, motor: Motor) -> None:
    said = run(copied)
    codes = {int(a): int(b) for a, b in re.findall(r"code (\d+) (\d+)", said)}
    assert len(codes) == 1008
    possible = sorted({inserted(code) for code in range(256)})
    for steps, code in codes.items():  # the least that is long enough
        assert code < 256 and inserted(code) == min(x for x in possible if x >= steps), steps
    register = int(re.search(r"register (\d+)", said)[1])  # type: ignore[index]
    assert register >> 8 == 1 << 4 | 3 << 2  # break input, idle levels; LOCK and MOE clear
    assert motor.dead_time <= inserted(register & 255) / 168e6 <= 1.05 * motor.dead_time
    assert float(re.search(r"range (\S+)", said)[1]) == motor.adc_range  # type: ignore[index]
    guarded = 1.5 * motor.u_dc  # the highest link that the core takes for real
    assert float(re.search(r"link (\S+)", said)[1]) >= guarded  # type: ignore[index]
    by = 2 * (1 + (int(re.search(r"clock (\d+)", said)[1]) >> 16 & 3))  # type: ignore[index]
    assert 84e6 / by <= 36e6  # of APB2; by the datasheet of the STM32F405
    volts = [float(x) for x in re.findall(r"duty \d (\S+)", said)]
    assert volts == pytest.approx([0.0, 0.3, 0.3, 0.0, 0.0, 0.0], abs=0.02)
    assert re.findall(r"bridge (\d+) (\d)", said) == [
        ("0", "1"), ("32", "1"), ("16", "0"), ("64", "0"),
    ]  # fmt: skip
    assert "again 1 1 0" in said
    assert re.findall(r"failed (.*)", said) == ["1 0 1 0"] * 2 + ["1 0 0 16"] * 2


@pytest.mark.parametrize(
    ("time", "fits"), [("0", False), ("1", True), ("6000", True), ("6001", False)]
)
def test_a_dead_time_that_tim1_has_not_is_refused(time: str, fits: bool, copied: Path) -> None:
    params = copied / "params.h"
    params.write_text(re.sub(r"(MOTOR_DEAD_TIME_NS) \d+", rf"\1 {time}", params.read_text()))
    words = ["gcc", "-std=c99", "-Wno-int-to-pointer-cast", "-fsyntax-only"]
    done = subprocess.run(
        [*words, copied / "example" / "cortex_m4.c"], capture_output=True, text=True, check=False
    )
    assert (done.returncode == 0) == fits
    assert fits or "1 to 1008 steps" in done.stderr


@pytest.mark.parametrize(
    ("finds", "flags", "fits"), [(1, "", True), (0, "", False), (0, "-DSHAFT_ANGLE=0.0f", True)]
)
def test_a_pole_that_does_not_show_has_to_be_given(
    finds: int, flags: str, fits: bool, copied: Path
) -> None:
    """At the wrong pole a drive may stand or run slowly for good."""
    params = copied / "params.h"
    text, n = re.subn(r"(DRIVE_FINDS_ROTOR) \d", rf"\1 {finds}", params.read_text())
    params.write_text(text)
    words = ["gcc", "-std=c99", "-Wno-int-to-pointer-cast", "-fsyntax-only", *flags.split()]
    done = subprocess.run(
        [*words, copied / "example" / "cortex_m4.c"], capture_output=True, text=True, check=False
    )
    assert n == 1 and (done.returncode == 0) == fits
    assert fits or "align its shaft, and define SHAFT_ANGLE" in done.stderr


def test_params_have_dead_time_and_range_of_the_motor_file() -> None:
    text = params_header(Motor.load("ebike_hub"), "")
    assert "#define MOTOR_DEAD_TIME_NS 500u " in text
    assert "#define MOTOR_ADC_RANGE 100.0f " in text
    assert f"#define MOTOR_U_DC {Motor.load('ebike_hub').u_dc:.1f}f " in text


def test_the_readme_opens_the_bridge(exported: Exported) -> None:
    text = (exported.folder / "README.md").read_text()
    assert "(FAULT_OVER_CURRENT | FAULT_STOPPED)) != 0) {\n        bridge_off();" in text
    assert "psi_f / L_d = 15.76 A" in text and "limited to 0 ... 1" in text
