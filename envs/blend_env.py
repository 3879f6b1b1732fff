"""One drive as a Gymnasium environment."""

from typing import Any

import gymnasium
import numpy as np
from gymnasium.error import ResetNeeded
from numpy.typing import ArrayLike, NDArray

from sensorless.envs.batch_state import BatchState
from sensorless.envs.blend_batch import BlendBatch
from sensorless.envs.blend_settings import (
    BlendSettings,
    checked_render_mode,
    checked_scenario,
    checked_seeds,
)
from sensorless.envs.blend_vector_env import spaces
from sensorless.envs.film import Film
from sensorless.envs.signals import Observation

_ROW = np.zeros(1, dtype=np.intp)


class BlendEnv(gymnasium.Env[Observation, ArrayLike]):
    """Choose the weight k_s that blends two position estimators of a running sensorless drive.

    **Description**
    An interior permanent-magnet motor runs under field-oriented control without a position sensor.
    High-frequency injection (hfi) finds the rotor at low speed. At higher speed an observer finds
    it from the back-EMF; ``design.estimator`` names it. In the default, coupled, k_s weighs the
    injection's error signal inside that observer. With a sliding-mode observer (smo) it weighs
    angles:

        theta = theta_smo + k_s wrap(theta_hfi - theta_smo)

    Machine (saturation, cross-coupling), inverter (dead time, DC link) and sampling (noise, offset,
    gain, ADC, one period of delay) are simulated at every PWM period; estimators and control are
    the code that runs on the target. Deviations are measured against the sensored twin: the same
    controller in the same scenario, fed by the true angle and speed.

    **Action**
    ``Box(-1, 1, (1,), float32)``, mapped to the wanted weight k_s = (action + 1) / 2: 1 is all
    injection, 0 all observer. The drive limits the slope of the weight in force. Actions outside
    -1 to 1 are refused, but for rounding, which is clipped.

    **Observation**
    ``Box((12,), float32)``, bounds in the table: only what the firmware measures or estimates,
    low-passed and divided by a fixed scale. "Ahead" means positive in the direction of motion.

    | Num | Observation    | Unit    | Value 1 is                         | Min  | Max |
    |-----|----------------|---------|------------------------------------|------|-----|
    | 0   | speed          | rad/s   | rated electrical speed             | 0    | 3   |
    | 1   | torque_current | A       | rated current, peak; ahead         | -4   | 4   |
    | 2   | disagreement   | rad     | 30 degrees; ahead                  | -3   | 3   |
    | 3   | acceleration   | rad/s^2 | rated electrical speed in 1 s      | -200 | 200 |
    | 4   | speed_error    | rad/s   | rated electrical speed; ahead      | -6   | 6   |
    | 5   | speed_ref      | rad/s   | rated electrical speed; ahead      | -3   | 3   |
    | 6   | k_s            | 1       | all injection                      | 0    | 1   |
    | 7   | emf            | V       | magnet flux times rated speed      | 0    | 10  |
    | 8   | hf_amplitude   | A       | answer of the machine without load | 0    | 6   |
    | 9   | hfi_residual   | 1       | 0.5                                | 0    | 4   |
    | 10  | smo_residual   | 1       | 0.5                                | 0    | 4   |
    | 11  | voltage        | V       | voltage limit                      | 0    | 20  |

    **Reward**
    The sum of named terms, none above 0, each also in ``info``: torque_deviation, torque_ripple,
    speed_deviation, angle, activity, injection (running costs, together at most 1.08 per 1 ms) and
    lost_penalty (-1000, once). ``sensorless.envs.reward`` has the formulas. With decisions of 1 ms,
    the default, ripple hardly counts: give ``decision_period=5e-3``, or take ``Blend-v1``.

    **Info**
    The terms, ``lost`` (bool), ``alarm`` (bool: the drive's own tests tell lost lock), and
    ``privileged``: true quantities for a critic, see ``sensorless.envs.privileged``. A policy must
    not see them.

    **Start**
    A scenario is a profile of speed, load and DC-link voltage, a starting point, and the mismatch
    between machine and controller. ``reset(seed=...)`` starts a stream of scenarios, and every
    reset takes the next one. By default they are `stress_1_scenarios`: everything at random, from
    rest or on a spinning shaft, whose speed the drive knows at the start, with its angle up to
    10 degrees off. ``scenarios="handoff"`` draws those of a suite instead (not
    ``envelope`` or ``machines``). ``reset(options={"scenario": s})`` runs a `Scenarios` of one row.
    It does not know which machine it was drawn for: draw it for the one of this environment.

    **End**
    Terminated when lock is lost: an angle error beyond 60 degrees for more than 10 ms,
    over-current, or a state that is not finite. Truncated at the end of the scenario (2 s by
    default), after ``max_episode_steps``, or when the sensored twin itself trips.

    Parameters
    ----------
    render_mode : None or "rgb_array"
        ``render()`` then returns a picture (200, 320, 3) of the last second: speed and its
        reference, torque and the twin's, k_s.
    **settings
        Fields of `BlendSettings`: motor, design, scenarios, weights, decision_period [s] and
        max_episode_steps.

    Notes
    -----
    Version 0. ``gymnasium.make_vec`` gives `BlendVectorEnv`: many drives, the same to the bit.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"]}  # noqa: RUF012
    settings_type: type[BlendSettings] = BlendSettings

    def __init__(self, *, render_mode: str | None = None, **settings: Any) -> None:
        self.batch = BlendBatch(1, self.settings_type.by_name(settings))
        self.render_mode = checked_render_mode(render_mode, self.metadata["render_modes"])
        decision = self.batch.periods * self.batch.motor.T_s
        self.metadata = {**self.metadata, "render_fps": max(1, round(1.0 / decision))}
        self.observation_space, self.action_space = spaces(self.batch.n_actions)
        self._film = None if render_mode is None else Film(decision, self.batch.motor)
        self._begun = False

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin the next episode; a seed starts the stream of scenarios anew."""
        (value,) = checked_seeds(seed, 1)
        scenario = checked_scenario(options, 1)
        super().reset(seed=value)
        if value is None and not self._begun:
            value = int(self.np_random.integers(2**63))
        if value is not None:
            self.batch.seed(_ROW, [value])
        self.batch.begin(_ROW, scenario)
        self._begun = True
        if self._film is not None:
            self._film.clear()
        return self.batch.observation()[0], {"privileged": self.batch.privileged()[0]}

    def step(self, action: ArrayLike) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Advance by one decision under an action of shape (1,), or more with gains."""
        if not self._begun:
            raise ResetNeeded("call reset() before step()")
        self.batch.advance(action)
        if self._film is not None:
            self._film.add(self.batch.sums()[0], float(self.batch.reference()[0]))
        outcome = self.batch.outcome()
        info: dict[str, Any] = {name: float(term[0]) for name, term in outcome.terms.items()}
        info["lost"] = bool(outcome.lost[0])
        info["alarm"] = bool(outcome.alarm[0])
        info["privileged"] = self.batch.privileged()[0]
        reward, ended = float(outcome.reward[0]), bool(outcome.ended[0])
        return self.batch.observation()[0], reward, info["lost"], ended, info

    def render(self) -> NDArray[np.uint8] | None:
        """Picture of the last second; None without a render mode."""
        return None if self._film is None else self._film.picture()

    def state(self) -> BatchState:
        """Copy of all memory of the drive."""
        return self.batch.state()

    def restore(self, state: BatchState) -> None:
        """Continue from a copy that `state` made with the same settings; errors otherwise.

        Scenarios that a function draws are compared by its name alone.
        """
        self.batch.restore(state)
        self._begun = True
        if self._film is not None:  # it shows what came after that
            self._film.clear()
