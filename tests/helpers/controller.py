"""One controller without a machine, called as firmware calls it."""

import numpy as np

from sensorless.core.api import CONTROL, Array, lib, pointer, struct_dtype
from sensorless.design.drive import DriveDesign
from sensorless.design.records import control_record
from sensorless.machine.motor import Motor
from tests.helpers.lock import unwatched

STATE, INPUT = struct_dtype("drive_state_t"), struct_dtype("drive_in_t")
GOOD = {"i_a": 0.5, "i_b": -0.2, "u_dc": 540.0, "omega_ref": 60.0, "k_s_ref": 0.5}


class Drive:
    """Its parameters and state, and a step with ``GOOD`` inputs but those given."""

    def __init__(
        self,
        motor: Motor,
        omega: float = 50.0,
        *,
        theta: float = 0.3,
        k_s: float = 1.0,
        seek: bool = False,
        estimator: str = "coupled",
    ) -> None:
        self.params = np.zeros(1, dtype=CONTROL)
        self.params[0] = control_record(motor, DriveDesign(estimator=estimator))
        unwatched(self.params)
        self.x = np.zeros(1, dtype=STATE)
        lib.drive_init(
            pointer(self.params, "drive_params_t[]"),
            pointer(self.x, "drive_state_t[]"),
            theta,
            omega,
            k_s,
        )
        if seek:
            lib.drive_find_rotor(pointer(self.x, "drive_state_t[]"))

    def step(self, **values: float) -> tuple[float, float]:
        signal = np.zeros(1, dtype=INPUT)
        for name, value in {**GOOD, **values}.items():
            signal[name] = value
        u = lib.drive_step(
            pointer(self.params, "drive_params_t[]"),
            pointer(self.x, "drive_state_t[]"),
            pointer(signal, "drive_in_t[]"),
        )
        return u.a, u.b

    def numbers(self) -> Array:
        """Every float of the state."""
        words = self.x.view(np.uint8)[: STATE.itemsize].copy().view(np.float32)
        return words[: STATE.fields["fault"][1] // 4] if STATE.fields else words
