import subprocess
import sys

import gymnasium


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
