"""Learned hand-over between two position estimators of a sensorless drive."""

from gymnasium import register as _register
from gymnasium import registry as _registry

__version__ = "0.1.0"

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

# Blend-v1 is another task, not a newer Blend-v0. Gymnasium calls a version old where there is a
# higher one of the same name; by this name the two are strangers.
_registry["sensorless/Blend-v1"].name = "Blend-with-gains"
