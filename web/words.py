"""Bits of the core in words."""

FAULTS = {
    "current": "a current sample was not plausible",
    "u_dc": "the DC-link voltage was not plausible",
    "command": "speed reference or weight out of range",
    "pole": "the start sequence was not sure of the north pole",
    "over_current": "the current vector was beyond the limit",
    "lock": "lock lost: the estimate is not the rotor's",
    "stopped": "no voltage any more after lost lock",
    "state": "its state was damaged: it started anew",
}
"""Bits of ``drive_state_t.fault``; any other has the name of the C core."""
LOST = {
    "angle": "lost: angle error beyond 60 degrees for 10 ms",
    "current": "lost: over-current trip",
    "nonfinite": "lost: a state is not finite",
    "twin": "not feasible: the drive with an encoder trips or runs away too",
}
ESTIMATORS = {
    "coupled": "Coupled observer (default)",
    "smo": "Sliding-mode observer (the paper's)",
    "flux": "Flux observer",
    "errors": "Sliding-mode, errors weighed in one loop",
    "unwrapped": "Sliding-mode, blend as printed (Eq. 26)",
}
"""Estimators, that of the default drive first; any other has its text of the settings."""
PHASES = {
    "done": "in control",
    "catch": "finding the rotor: does it spin?",
    "fly": "finding the rotor: it spins, settling",
    "scan": "finding the rotor: axis",
    "lock": "finding the rotor: settling on the axis",
    "pole": "finding the rotor: which pole",
    "settle": "finding the rotor: settling",
    "quiet": "waiting to find the rotor again",
}
