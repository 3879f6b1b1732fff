"""The simulated drive as a source of measurements, with errors of sensors and inverter."""

from collections.abc import Sequence

import numpy as np

from sensorless.core.api import Array
from sensorless.core.machine import COMMAND, commission_run
from sensorless.design.drive import DriveDesign
from sensorless.envs.counter_random import check_seed
from sensorless.envs.scenarios.scenario import Scenarios, SimFactory
from sensorless.envs.scenarios.stress import stress_scenarios
from sensorless.errors import UserError
from sensorless.identify.machine.electric import Sensors
from sensorless.identify.machine.log import Part
from sensorless.identify.machine.nameplate import Nameplate
from sensorless.identify.machine.source import Command, Gains
from sensorless.machine.motor import Motor

ERRORS = ("dead_time", "noise", "gain", "offset", "detailed", "u_transistor", "u_diode")
"""Of sensors and inverter, drawn as in the suite ``stress``."""
DETAILS = ("emf_5", "emf_7", "saliency_6", "p_iron", "ripple", "ripple_hz", "ripple_phase")
"""Of the machine and the DC link, likewise."""


def real_drive(motor: Motor, seed: int, details: bool = False) -> Scenarios:
    """One drive at rest whose sensors and inverter have errors; rotor at any angle.

    ``details`` adds harmonics, iron loss and the ripple of the DC link.

    Raises
    ------
    UserError
        The seed is out of range.
    """
    check_seed(seed)
    drawn = stress_scenarios(motor, np.array([seed], dtype=np.uint64))
    s = Scenarios.nominal(motor, drawn.seed, 1.0)
    for name in ERRORS + (DETAILS if details else ()):
        setattr(s, name, getattr(drawn, name))
    s.theta_0[:] = drawn.theta_0
    return s


class Simulated:
    """The simulated drive: the true machine under one scenario, from which it only measures."""

    def __init__(self, motor: Motor, scenario: Scenarios) -> None:
        self.parts: list[Part] = []
        self._sim = SimFactory(motor, DriveDesign()).build(scenario, twin=False)
        self._plate = Nameplate.of(motor)

    def run(self, stage: str, commands: Sequence[Command], gains: Gains | None = None) -> Part:
        """Run commands through inverter, machine and sensors, in one call of the core.

        Raises
        ------
        UserError
            The current exceeds the name plate's limit.
        """
        if gains is not None:
            _set_gains(self._sim, gains, self._plate)
        limit = self._plate.i_limit
        rows = commission_run(self._sim, _records(commands, self._plate.T_s), limit)
        part = Part(stage, rows)
        self.parts.append(part)
        if abs(Sensors().current(part)[-1]) > limit:
            raise UserError(
                f"stage {stage}: current above {limit:.3g} A; check the name plate's rated current "
                "and voltage"
            )
        return part


def _records(commands: Sequence[Command], T_s: float) -> Array:
    out = np.zeros(len(commands), dtype=COMMAND)
    for row, c in zip(out, commands, strict=True):
        row["kind"], row["n"] = c.kind, max(1, round(c.time / T_s))
        row["from"], row["to"] = c.start, c.start if c.end is None else c.end
        row["go_on"], row["theta"] = int(c.theta is None), c.theta or 0.0
        row["omega_0"], row["omega_1"] = c.omega
        row["i_end"] = c.until
        row["damp"], row["follow"] = c.damp, c.follow
    return out


def _set_gains(sims: Array, g: Gains, plate: Nameplate) -> None:
    """Fill the current control with the same numbers for both axes; nothing else of it is used."""
    control = sims["control"]["control"]
    control[...] = 0
    for axis in "dq":
        control[f"k_t_{axis}"] = g.bandwidth * g.L
        control[f"k_p_{axis}"] = 2.0 * g.bandwidth * g.L - g.R
        control[f"k_i_{axis}"] = g.bandwidth**2 * g.L * plate.T_s
        control[f"L_{axis}"] = g.L
    control["i_d_min"] = -plate.i_rated
