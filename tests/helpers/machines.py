"""Flux maps that several tests integrate or fit."""

from pathlib import Path

from sensorless.machine.motor import Saturation

MEASURED_MAP = Path(__file__).parents[1] / "data" / "flux_maps" / "baldor_400rpm_map.csv"
"""Measured on the machine of ``pmsyrm_5600w``."""

BRIDGE = Saturation(
    a_d0=3.96,
    a_dd=28.5,
    S=4,
    a_q0=5.89,
    a_qq=2.67,
    T=6,
    a_dq=41.5,
    U=1,
    V=1,
    a_b=81.75,
    a_bp=1.0,
    k_q=0.1,
    psi_n=0.804,
    W=2,
)
"""A machine whose bridges saturate against the magnet."""
