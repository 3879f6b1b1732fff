"""The whole procedure: from a name plate to the numbers of the machine."""

from dataclasses import dataclass, replace

import numpy as np

from sensorless.errors import UserError
from sensorless.identify.machine.axis import align
from sensorless.identify.machine.curves import fit_curves
from sensorless.identify.machine.edges import at_edges
from sensorless.identify.machine.electric import Stator
from sensorless.identify.machine.equations import COVERED
from sensorless.identify.machine.hold import Resistance, measure_offsets, measure_resistance
from sensorless.identify.machine.joint import fit_jointly
from sensorless.identify.machine.model import fit_model
from sensorless.identify.machine.nameplate import Nameplate
from sensorless.identify.machine.pulses import Samples, measure_pulses, samples
from sensorless.identify.machine.source import Source
from sensorless.identify.machine.spin import Spin, measure_spin
from sensorless.machine.map_fit import MapFit


@dataclass(frozen=True)
class Identified:
    """All that the drive found out about its machine."""

    plate: Nameplate
    resistance: Resistance
    samples: Samples
    spin: Spin
    map_fit: MapFit


def identify_machine(source: Source, plate: Nameplate) -> Identified:
    """Measure resistance, flux map, magnet and inertia, in that order.

    Raises
    ------
    UserError
        Something cannot be identified; the message says what and why.
    """
    try:
        return _identified(source, plate)
    except UserError:
        raise
    except (np.linalg.LinAlgError, ArithmeticError, ValueError, IndexError) as error:
        raise UserError(
            f"the readings fit no machine ({error}); look for outliers and wrong units in them"
        ) from None


def _identified(source: Source, plate: Nameplate) -> Identified:
    sensors = measure_offsets(source)
    resistance = measure_resistance(source, plate, sensors)
    stator = Stator(resistance.sensors, resistance.inverter, resistance.R_s, plate.T_s)
    aligned = align(source, stator, plate)
    groups = measure_pulses(source, stator, plate, aligned)
    still = fit_curves(samples(groups, 0.0, 0.0), plate.i_rated)
    spin = measure_spin(source, stator, plate, still, aligned)
    first = spin.mechanics
    turn = 1.5 * plate.n_p**2 / first.J
    for _ in range(2):
        moved = samples(groups, spin.psi_f, turn)
        spin = spin.again(fit_curves(moved, plate.i_rated))
    fit = fit_model(moved, spin.psi_f, plate.i_rated)
    for _ in range(2):
        model, most = fit.saturation, COVERED * plate.i_rated
        edged = [at_edges(g, stator, model, most) for g in groups]
        doubt = first.J_std / first.J
        joint = fit_jointly(edged, model, spin.psi_f, turn, doubt, plate)
        spin = spin.again(fit_curves(joint.samples, plate.i_rated), joint.g)
        fit = fit_model(joint.samples, spin.psi_f, plate.i_rated)
    J = first.J / joint.share
    spin = replace(spin, mechanics=replace(first, J=J, J_std=J * joint.doubt))
    return Identified(plate, resistance, joint.samples, spin, fit)
