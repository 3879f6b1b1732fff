"""motulator's sensorless drive: machine, converter, mechanics, observer and control of one IPMSM.

Averaged converter without dead time, or carrier PWM with 2 us of it; no measurement errors.
"""

from benchmarks.peer_clock import rate, tell
from benchmarks.words import parser

J = 0.02
T_STOP = 0.2


def drive(kind: str, pwm: bool) -> int:
    """Run one drive at 350 r/min; returns its control periods."""
    from motulator.drive import model
    from motulator.drive.control import sm

    par = model.SynchronousMachinePars(n_p=2, R_s=2.484, L_d=0.063, L_q=0.126, psi_f=0.993)
    plant = model.Drive(
        model.SynchronousMachine(par),
        model.MechanicalSystem(J=J),
        model.VoltageSourceConverter(u_dc=540.0, t_d=2e-6 if pwm else 0.0),
        pwm=pwm,
    )
    if kind == "flux observer":
        cfg = sm.FluxVectorControllerCfg(i_s_max=11.0, sensorless=True)
        inner = sm.FluxVectorController(par, cfg)
    else:
        cfg = sm.CurrentVectorControllerCfg(i_s_max=11.0, sensorless=True)
        inner = sm.SignalInjectionController(par, cfg, U_inj=100.0)
    control = sm.VectorControlSystem(inner, sm.SpeedController(J=J, alpha_s=25.0))
    control.set_speed_ref(36.65)
    found = model.Simulation(plant, control).simulate(t_stop=T_STOP)
    if not found.success:
        raise RuntimeError("the simulation stopped early: the figure would be wrong")
    return len(found.ctrl.t)


def main() -> None:
    """Control periods with and without PWM and dead time, for two ways to find the angle."""
    parser(__doc__).parse_args()
    rates = {
        f"{kind}, {'PWM and dead time' if pwm else 'averaged'}": rate(
            lambda kind=kind, pwm=pwm: drive(kind, pwm)  # type: ignore[misc]
        )
        for pwm in (False, True)
        for kind in ("flux observer", "injection")
    }
    tell(rates, ("motulator", "numpy", "scipy"))


if __name__ == "__main__":
    main()
