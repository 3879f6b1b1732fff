"""Picture of the last second of a drive, drawn with NumPy alone."""

from collections import deque

import numpy as np
from numpy.typing import NDArray

from sensorless.core.api import Array
from sensorless.machine.motor import Motor

Picture = NDArray[np.uint8]

SPAN = 1.0
"""Time across a picture [s]."""
HEIGHT, WIDTH, EDGE = 200, 320, 4
"""Size of a picture, and the frame around each of its strips [pixels]."""
BLUE, ORANGE, GREY = (31, 119, 180), (255, 127, 14), (160, 160, 160)
STRIPS = (
    (("reference", GREY), ("speed", BLUE)),
    (("twin", GREY), ("torque", ORANGE)),
    (("k_s", BLUE),),
)
"""Curves of each strip, from behind to the front."""


class Film:
    """The decisions of the last second, and their picture: speed, torque and k_s, one strip each.

    Parameters
    ----------
    decision : float
        Time between decisions [s].
    motor : Motor
        Its rated values fill three quarters of a strip to either side of zero.
    """

    def __init__(self, decision: float, motor: Motor) -> None:
        speed, torque = 0.75 * motor.n_p / motor.omega_rated, 0.75 / motor.tau_rated
        self._scale = {"reference": speed, "speed": speed, "twin": torque, "torque": torque}
        self._rows: deque[dict[str, float]] = deque(maxlen=max(2, round(SPAN / decision)))

    def clear(self) -> None:
        """Begin another episode."""
        self._rows.clear()

    def add(self, sums: Array, reference: float) -> None:
        """Take in the sums of a decision and the speed reference [rad/s]."""
        n = max(float(sums["n"]), 1.0)
        self._rows.append({
            "reference": self._scale["reference"] * reference,
            "speed": self._scale["speed"] * float(sums["omega_m"]) / n,
            "twin": self._scale["twin"] * float(sums["tau_twin"]) / n,
            "torque": self._scale["torque"] * float(sums["tau"]) / n,
            "k_s": 2.0 * float(sums["k_s"]) / n - 1.0,
        })  # fmt: skip

    def picture(self) -> Picture:
        """RGB picture (HEIGHT, WIDTH, 3)."""
        out = np.full((HEIGHT, WIDTH, 3), 255, dtype=np.uint8)
        height = HEIGHT // len(STRIPS)
        for j, curves in enumerate(STRIPS):
            strip = out[j * height + EDGE : (j + 1) * height - EDGE, EDGE : WIDTH - EDGE]
            strip[:] = 240
            strip[strip.shape[0] // 2] = 200
            for name, colour in curves:
                self._draw(strip, name, colour)
        return out

    def _draw(self, strip: Picture, name: str, colour: tuple[int, int, int]) -> None:
        """One curve from the left, -1 at the bottom of the strip and 1 at its top."""
        if not self._rows:
            return
        rows, columns = strip.shape[:2]
        y = np.array([row[name] for row in self._rows])
        at = np.linspace(0.0, self._rows.maxlen - 1, columns)  # type: ignore[operator]
        seen = np.flatnonzero(at <= len(y) - 1)
        value = np.clip(np.nan_to_num(np.interp(at[seen], np.arange(len(y)), y)), -1.0, 1.0)
        pixel = np.rint((0.5 - 0.5 * value) * (rows - 1)).astype(int)
        before = np.concatenate([pixel[:1], pixel[:-1]])
        for column, a, b in zip(seen, np.minimum(pixel, before), np.maximum(pixel, before),
                                strict=True):  # fmt: skip
            strip[a : b + 1, column] = colour
