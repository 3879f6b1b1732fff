"""The drive as a user describes it: bandwidths and choices."""

import math
from dataclasses import dataclass

from sensorless.core.api import enumeration
from sensorless.settings import check, derived, number, switch, word

ESTIMATORS = enumeration("ESTIMATE_")
"""Numbers of the C core by the name that the setting ``estimator`` takes."""

RENAMED = {"angles": "smo"}
"""Old names of estimators, and their names now."""


@dataclass(frozen=True)
class DriveDesign:
    """Bandwidths and choices of the control core; everything else follows from the motor."""

    hfi_pll_hz: float | None = derived("Hz", 1, 1000, "natural frequency of the injection's PLL")
    smo_pll_hz: float | None = derived("Hz", 1, 1000, "natural frequency of the PLL on the EMF")
    smo_gain: float = number(1.0, "1", 0.05, 1.95, "SMO gain over the deadbeat gain L_d / T_s")
    smo_cross_hz: float | None = derived(
        "Hz", 0.5, math.inf, "low-pass on the speed in the SMO's cross term", endless=True
    )
    smo_k: float = number(2.5, "1", 0.05, 100, "bound on the SMO's EMF over the rated no-load EMF")
    smo_emf_hz: float = number(
        math.inf, "Hz", 1, math.inf, "low-pass on the EMF; inf: none", endless=True
    )
    L_q_bias: float = number(0.7, "1", 0.3, 1.5, "SMO's q inductance over the apparent one")
    L_q_motoring: float = number(
        0.9, "1", 0.3, 1.5, "SMO's q inductance over the apparent one as a motor, if above that"
    )
    smo_floor_rpm: float | None = derived(
        "r/min", 0, 1e4, "speed below which the EMF is not used; 0: no warm start"
    )
    error_pll_hz: float | None = derived(
        "Hz", 1, 1000, "natural frequency of the one PLL of estimator=errors"
    )
    flux_pll_hz: float | None = derived(
        "Hz", 0.5, 1000, "natural frequency of the flux observer's speed estimate"
    )
    flux_gain: float = number(0.2, "1", 0, 5, "how fast the flux correction rises with speed")
    flux_L_q_bias: float = number(0.9, "1", 0.3, 1.5, "flux observer's L_q over the apparent one")
    coupled_L_q_bias: float | None = derived(
        "1", 0.3, 1.5, "coupled observer's q inductance over the apparent one"
    )
    coupled_flux_hz: float | None = derived(
        "Hz", 0.5, 1000, "double pole of the coupled observer's voltage model"
    )
    coupled_injection_hz: float | None = derived(
        "Hz", 0.1, 1000, "double pole with which injection corrects the coupled observer"
    )
    coupled_linear: bool = switch(
        False, "coupled observer's flux correction without the sigmoid, in proportion to the error"
    )
    speed_bound: float = number(
        2.5, "1", 0.5, math.inf, "bound on estimated speeds over rated speed", endless=True
    )
    speed_hz: float | None = derived("Hz", 0.1, 50, "natural frequency of the speed loop")
    speed_weight: float = number(0.0, "1", 0, 1, "reference weight of the speed loop: 0 IP, 1 PI")
    current_hz: float | None = derived("Hz", 10, 2000, "bandwidth of the current loop")
    i_q_slew: float | None = derived("A/s", 1, 1e06, "slope limit of the torque current")
    k_s_slew: float = number(50.0, "1/s", 1, 5000, "slope limit of the weight k_s")
    injection_hold: float = number(
        0.02, "s", 0, 10, "time the injection stays on after k_s reached zero"
    )
    signal_hz: float | None = derived("Hz", 1, 1000, "low-pass on the signals that a schedule sees")
    dead_time_share: float | None = derived("1", 0, 1, "share of the dead time that is compensated")
    hfi_scheme: str = word(
        "rotating",
        "how the alternating current is found",
        {
            "rotating": "second difference in the rotating frame",
            "stationary": "first difference in the stationary frame, as published (Eq. 9)",
        },
    )
    hfi_delay_cure: bool = switch(
        True, "turn the injected voltage by the 1.5 periods that it acts late"
    )
    hfi_normalised: bool = switch(
        True,
        "divide the injection's error signal by the magnitude of the current's answer (Eq. 7); "
        "false: as it is (Eq. 15)",
    )
    estimator: str = word(
        "coupled",
        "what estimates beside the injection, and how both become one",
        {
            "smo": "sliding-mode observer, angles weighed",
            "unwrapped": "the same without wrap, as printed (Eq. 26)",
            "errors": "sliding-mode observer and injection in one loop, error signals weighed",
            "flux": "flux observer, angles weighed",
            "coupled": "one observer of flux and speed, corrected by injection with the weight",
        },
        renamed=RENAMED,
    )
    cross_line_torque: float = number(
        0.5, "1", 0.05, 2, "torque over rated that the line of cross=line is fitted up to"
    )
    smo_switching: str = word(
        "sigmoid",
        "what corrects the SMO's current",
        {
            "sigmoid": "linear inside a boundary layer (Eq. 24)",
            "sign": "signum (Eq. 22): slides, chatters",
            "super_twisting": "slides in the second order, its gains follow the speed",
        },
        was="smo_sign",
    )
    lag_cure: bool = switch(True, "EMF from the exact steady-state relation")
    L_q_table: bool = switch(
        True, "observer's q inductance over the torque current; false: the datasheet's constant"
    )
    cross: str = word(
        "table",
        "compensation of cross-coupling",
        {
            "none": "no compensation",
            "line": "a line through zero",
            "table": "that of the flux map",
            "FILE.json": "as sensorless identify cross-coupling measured it",
        },
    )
    lost_lock: str = word(
        "report",
        "what the drive does when its tests tell lost lock; in each case it sets a fault bit",
        {
            "report": "nothing else",
            "restart": "goes on with estimator=coupled; if that does not help, seeks its rotor "
            "anew, up to five times, then stops",
            "stop": "stops, with no voltage until it is started again",
        },
    )
    mtpa: bool = switch(True, "d current of maximum torque per ampere; false: zero")
    carrier: bool = switch(
        False, "inverter with the switching instants of a carrier; false: with its mean voltage"
    )

    def __post_init__(self) -> None:
        """Check every setting.

        Raises
        ------
        UserError
            Names the setting, its value and what it must be.
        """
        check(self)
