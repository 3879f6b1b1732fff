"""``sensorless/Blend-v1``: the agent sets k_s and gains of the drive."""

from sensorless.envs.blend_env import BlendEnv
from sensorless.envs.blend_settings import BlendSettings, GainSettings
from sensorless.envs.blend_vector_env import BlendVectorEnv


class GainEnv(BlendEnv):
    """Choose the weight k_s, and with it gains of the drive that go with the hand-over.

    Description, observation, info, start and end are those of `BlendEnv` (``Blend-v0``).

    **Action**
    ``Box(-1, 1, (1 + m,), float32)``: first k_s = (action + 1) / 2, then a value for each of the m
    names in ``gains``, all four by default:

    | Name      | What it changes                                        | at -1 | at 0 | at 1 |
    |-----------|--------------------------------------------------------|-------|------|------|
    | observer  | bandwidth of the observer's loop                       | 0.5   | 1    | 2    |
    | injection | bandwidth of the injection estimator                   | 0.5   | 1    | 2    |
    | l_q       | q inductance of the observer                           | 0.8   | 1    | 1.25 |
    | amplitude | injected voltage                                       | 0.5   | 1    | 1    |

    Numbers are factors on the static gain; ``gain_ranges`` sets others,
    as ``{"observer": Gain(0.7, 1.5)}`` of `sensorless.core.gains`. A value follows the action
    with a time constant of 10 ms. With all gains at 0 the drive is that of ``Blend-v0``, to the
    bit; the reward and the default interval are not.

    **Reward**
    The terms of `WindowWeights`: running costs over the last 20 ms, integrated over time, together
    at most 0.30 per 1 ms, and lost_penalty (-200, once). A return hardly depends on a decision
    period that divides 20 ms and is whole PWM periods, but for what the decisions change.
    ``sensorless.envs.window_reward`` has the formulas.

    Parameters
    ----------
    render_mode : None or "rgb_array"
        As in `BlendEnv`.
    **settings
        Fields of `GainSettings`: those of ``Blend-v0``, ``gains`` and ``gain_ranges``. A decision
        takes 5 ms by default, ``sensorless.decision`` says why.
    """

    settings_type: type[BlendSettings] = GainSettings


class GainVectorEnv(BlendVectorEnv):
    """``sensorless/Blend-v1`` for n drives; `GainEnv` describes it, `BlendVectorEnv` the rest."""

    settings_type: type[BlendSettings] = GainSettings
