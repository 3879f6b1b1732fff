"""Learned hand-over between two position estimators of a sensorless drive."""

from gymnasium import register as _register

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
