"""The file of a rule with the parameters that tuning found."""

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sensorless.baselines.rule import Values
from sensorless.design.carried import Carried, carried
from sensorless.errors import UserError, shown
from sensorless.files import read_json, reason, write_atomic

FORMAT = "sensorless-tuned/1"


@dataclass(frozen=True)
class Tuned:
    """A tuned rule, as the file holds it."""

    rule: str
    parameters: Values
    """In the rule's own units, which scale with the machine."""
    provenance: Mapping[str, Any]
    """JSON types."""

    def carried(self, where: str) -> Carried:
        """Machine and settings that it was tuned on; ``where`` names the file in errors."""
        return carried(self.provenance, where)

    def save(self, path: Path) -> None:
        """Write the file whole or not at all."""
        data = {
            "format": FORMAT,
            "rule": self.rule,
            "parameters": dict(self.parameters),
            "provenance": dict(self.provenance),
        }
        write_atomic(path, json.dumps(data, indent=1, allow_nan=False) + "\n")

    @classmethod
    def load(cls, path: Path) -> "Tuned":
        """Read a file that ``save`` wrote; the rule and its parameters are not checked here.

        Raises
        ------
        UserError
            The file cannot be read, or has another format.
        """
        try:
            data = read_json(path)
        except (OSError, ValueError) as error:
            raise UserError(
                f"{path}: {reason(error)}; give a file that sensorless tune wrote"
            ) from None
        if not isinstance(data, dict) or data.get("format") != FORMAT:
            found = data.get("format") if isinstance(data, dict) else type(data).__name__
            raise UserError(
                f"{path}: format {shown(found)} is not {FORMAT!r}; give a file that sensorless "
                "tune wrote"
            )
        rule, parameters = data.get("rule"), data.get("parameters")
        provenance = data.get("provenance", {})
        if not isinstance(rule, str):
            raise UserError(f"{path}: rule: {shown(rule)}; give the name of a rule")
        if not isinstance(parameters, dict) or not all(map(_is_number, parameters.values())):
            raise UserError(f"{path}: parameters: {shown(parameters)}; give numbers by name")
        if not isinstance(provenance, dict):
            raise UserError(f"{path}: provenance: {shown(provenance)}; give a JSON object")
        return cls(rule, parameters, provenance)


def _is_number(x: object) -> bool:
    return isinstance(x, int | float) and not isinstance(x, bool) and math.isfinite(x)
