"""What is known of a machine and its drive before any measurement."""

import dataclasses
import math
from dataclasses import dataclass

from sensorless.machine.motor import Motor
from sensorless.units import rad_per_s


@dataclass(frozen=True)
class Nameplate:
    """Name plate of the machine and data of the inverter. SI units, peak values."""

    name: str
    n_p: int
    tau_rated: float
    i_rated: float
    n_rated_rpm: float
    u_dc: float
    T_s: float
    i_max: float
    i_trip: float
    u_inj: float
    dead_time: float
    adc_range: float
    adc_bits: int

    @classmethod
    def of(cls, motor: Motor) -> "Nameplate":
        """Take a motor file's rating and drive, and of its machine the pole pairs alone."""
        return cls(**{f.name: getattr(motor, f.name) for f in dataclasses.fields(cls)})

    @property
    def omega(self) -> float:
        """Rated electrical speed [rad/s]."""
        return rad_per_s(self.n_p * self.n_rated_rpm)

    @property
    def u_base(self) -> float:
        """Largest phase voltage of the linear range [V]."""
        return self.u_dc / math.sqrt(3.0)

    @property
    def i_limit(self) -> float:
        """Current at which a test stops [A]."""
        return 0.98 * min(self.i_trip, self.adc_range)
