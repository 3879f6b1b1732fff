"""Learned hand-over between two position estimators of a sensorless drive."""

import warnings as _warnings

from gymnasium import register as _register

# Gymnasium calls a version old where there is a higher one; here v1 is another task: gains as well.
_warnings.filterwarnings("ignore", message=".*sensorless/Blend-v0 is out of date")

_register(
    id="sensorless/Blend-v0",
    entry_point="sensorless.envs.blend_env:BlendEnv",
    vector_entry_point="sensorless.envs.blend_vector_env:BlendVectorEnv",
)
_register(
    id="sensorless/Blend-v1",
    entry_point="sensorless.envs.blend_v1:GainEnv",
    vector_entry_point="sensorless.envs.blend_v1:GainVectorEnv",
)
