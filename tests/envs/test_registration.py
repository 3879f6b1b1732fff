import subprocess
import sys
import warnings

import gymnasium
import pytest

from sensorless.design.drive import DriveDesign
from sensorless.errors import UserError


def test_import_registers_and_stays_cheap() -> None:
    """Neither the compiled core nor a learning library comes with the bare import."""
    code = (
        "import sys, gymnasium, sensorless; gymnasium.spec('sensorless/Blend-v0'); "
        "heavy = {'torch', 'stable_baselines3', 'scipy', 'matplotlib', 'sensorless._core'}; "
        "print(sorted(heavy & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_settings_pass_through_make() -> None:
    env = gymnasium.make("sensorless:sensorless/Blend-v0", decision_period=0.002)
    assert env.unwrapped.batch.periods == 10  # type: ignore[attr-defined]
    assert env.spec is not None and env.spec.to_json()


@pytest.mark.parametrize("name", ["sensorless/Blend-v0", "sensorless/Blend-v1"])
def test_no_version_is_called_out_of_date(name: str) -> None:
    """Whatever filters of warnings are set."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        env = gymnasium.make(f"sensorless:{name}")
        gymnasium.make_vec(name, num_envs=2).close()
    assert env.spec is not None
    again = gymnasium.make(gymnasium.envs.registration.EnvSpec.from_json(env.spec.to_json()))
    assert again.spec is not None and again.spec.id == name


def test_a_design_comes_from_a_file_too() -> None:
    """Gymnasium's own JSON of an environment, and a YAML file, have the settings by name."""
    spec = gymnasium.make("sensorless/Blend-v0", design=DriveDesign(estimator="flux")).spec
    assert spec is not None
    again = gymnasium.make(gymnasium.envs.registration.EnvSpec.from_json(spec.to_json()))
    design = again.unwrapped.batch.settings.design  # type: ignore[attr-defined]
    assert design == DriveDesign(estimator="flux")


@pytest.mark.parametrize(
    ("design", "said"),
    [
        ({"observer": "flux"}, "design: observer: unknown: use only"),
        ({"speed_hz": "fast"}, "design: speed_hz: 'fast': must be a number"),
        ({3: 1}, "design: 3: unknown"),
    ],
)
def test_a_wrong_design_is_named(design: object, said: str) -> None:
    with pytest.raises(UserError, match=said):
        gymnasium.make("sensorless/Blend-v0", design=design)
