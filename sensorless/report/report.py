"""Judges a policy, draws figures, and writes one HTML page with the pictures beside it."""

import json
import shlex
from collections.abc import Sequence
from dataclasses import asdict
from importlib.metadata import version
from pathlib import Path

from sensorless.agents.loading import VERDICT
from sensorless.baselines.linear import EQ25_BAND, linear_table
from sensorless.envs.scenarios.words import scenario_from
from sensorless.evaluation.evaluate import PolicyProgress, evaluate
from sensorless.evaluation.objective import LOST_WEIGHT
from sensorless.evaluation.results import Results
from sensorless.evaluation.trace import trace
from sensorless.files import ensure_writable, write_atomic
from sensorless.plots.envelope import envelope_maps
from sensorless.plots.figure import png, require_matplotlib
from sensorless.plots.learning import curves_of, learning_curves, shipped_levels
from sensorless.plots.schedule import lost_by_place, schedule_maps
from sensorless.plots.waveforms import waveforms
from sensorless.policies import shipped
from sensorless.policies.bench import Bench
from sensorless.policy import TablePolicy, design_for
from sensorless.report.cases import Case, cases
from sensorless.report.page import Figure, Section, render

PAGE = "index.html"
SUITES = ("stress-1", "handoff")


class Report:
    """Writes a report about one policy.

    Parameters
    ----------
    run : str
        Policy that the report is about, as in ``sensorless.policies.registry.known``.
    bench : Bench
        Machine and drive.
    others : sequence of str, optional
        Policies to compare with, waveforms with the first of them; by default Eq. 25 on the paper's
        observers and on the design's, every shipped tuned rule, and the bounds.
    options : sequence of str
        Words of the command line for this motor and design.
    progress : optional
        Called with the name of what is evaluated and the share done.

    Raises
    ------
    UserError
        A policy does not exist, or matplotlib is missing.
    """

    def __init__(
        self,
        run: str,
        bench: Bench,
        *,
        others: Sequence[str] | None = None,
        options: Sequence[str] = (),
        progress: PolicyProgress | None = None,
    ) -> None:
        require_matplotlib()
        self.run, self.bench = run, bench
        self.motor, self.design = bench.motor, bench.design
        self.options, self.progress = options, progress
        wanted = others or ("sliding_mode", "eq25", *shipped.tuned_names(), "oracle", "sensored")
        self.others = [word for word in wanted if word != run] or ["sliding_mode"]
        self.policy, self.reference = bench.policy(run), bench.policy(self.others[0])

    def write(
        self, folder: Path, suites: Sequence[str], seed: int, size: int, grid: int, command: str
    ) -> Path:
        """Judge, draw and write; return the page. Every file is written whole or not at all.

        Parameters
        ----------
        folder : Path
            Created if it does not exist.
        suites : sequence of str
            Suites to judge on, ``size`` scenarios each.
        grid : int
            Points of the envelope maps along each axis.
        command : str
            Command that the user typed, for the page.
        """
        ensure_writable(folder)
        sections, results = [], []
        for name in suites:
            results.append(self._evaluate(name, seed, size, [self.run, *self.others]))
            sections.append(self._section(results[-1]))
        figures = [self._envelope(grid, seed), *self._schedule(), *self._curves()]
        page = render(
            self.policy.name,
            self._about(),
            sections,
            figures,
            self._commands(command),
            self._versions(results[0]),
            asdict(design_for(self.policy, self.design)),
        )
        for result in results:
            result.write(folder / f"results-{result.suite}.json", scenarios=False)
        for figure in [f for s in sections for f in s.figures] + figures:
            write_atomic(folder / figure.file, figure.png)
        write_atomic(folder / PAGE, page)
        return folder / PAGE

    def _evaluate(self, suite: str, seed: int, size: int, policies: Sequence[str]) -> Results:
        def report(name: str, done: float) -> None:
            if self.progress is not None:
                self.progress(f"{suite}: {name}", done)

        chosen = self.bench.policies(policies)
        return evaluate(self.motor, self.design, suite, seed, size, chosen, progress=report)

    def _section(self, results: Results) -> Section:
        policies = [word for name in (self.run, *self.others) for word in ("--policy", name)]
        setting = ["--suite", results.suite, "--seed", str(results.seed), "--size"]
        again = ["evaluate", *policies, *setting, str(results.size), "--details"]
        places = Figure(
            f"{results.suite}-places.png",
            "Where lock is lost",
            "Share of the scenarios that came to a place and were lost there, with 95 % Wilson "
            "intervals. The place is where the sensored twin was.",
            png(lost_by_place(results)),
        )
        chosen = cases(results, self.policy.name, self.reference.name)
        return Section(
            results,
            self._command(*again),
            [places, *(self._waveforms(case) for case in chosen)],
        )

    def _waveforms(self, case: Case) -> Figure:
        scenario = scenario_from(case.scenario, self.motor)
        traces = {
            f"{case.scenario} under {policy.name}": trace(policy, scenario, self.motor, self.design)
            for policy in (self.policy, self.reference)
        }
        words = ["simulate", "--scenario", case.scenario, "--policy", self.run]
        return Figure(
            f"{case.key}.png",
            case.title,
            "Speed, torque, angle errors (truth minus estimate) of both estimators and their "
            "blend, and the weight.",
            png(waveforms(traces)),
            self._command(*words, "--plot", "case.png"),
        )

    def _envelope(self, grid: int, seed: int) -> Figure:
        policies = list(dict.fromkeys(("hfi", "smo", "sliding_mode", "eq25", self.run, "sensored")))
        results = self._evaluate("envelope", seed, grid * grid, policies)
        words = [word for name in policies for word in ("--policy", name)]
        words += ["--suite", "envelope", "--size", str(grid * grid), "--seed", str(seed)]
        return Figure(
            "envelope.png",
            "Where lock holds over speed and load",
            "Nominal parameters. The drive starts at its speed; the load rises within 0.2 s and "
            "stays for 0.6 s.",
            png(envelope_maps(results, self.motor)),
            self._command("evaluate", *words, "--plot", "envelope.png"),
        )

    def _schedule(self) -> list[Figure]:
        if not isinstance(self.policy, TablePolicy):
            return []
        name, eq25 = self.policy.name, linear_table(*EQ25_BAND)
        return [
            Figure(
                "schedule.png",
                "The schedule as a table, beside Eq. 25",
                "Weight k_s over the axes of the table. Dots are its nodes, lines are k_s = 0.1, "
                "0.5 and 0.9. Eq. 25 is the linear rule of the source paper.",
                png(schedule_maps(name, self.policy.table, eq25, self.motor)),
            )
        ]

    def _curves(self) -> list[Figure]:
        folder = shipped.reference_run(self.run) or Path(self.run)
        curves = curves_of(folder) if folder.is_dir() else {}
        if not curves:
            return []
        levels = shipped_levels(folder)
        lines = f" Lines: {' and '.join(levels)} on the same scenarios." if levels else ""
        return [
            Figure(
                "learning.png",
                "Learning curves",
                "Validation during training, on scenarios that neither training nor judging uses. "
                f"The first point is the start of training. The objective is {LOST_WEIGHT:g} times "
                f"the lost rate plus torque deviation plus torque ripple.{lines}",
                png(learning_curves(curves, levels)),
            )
        ]

    def _about(self) -> dict[str, str]:
        facts = {"policy": self.run, "motor": f"{self.motor.name}, {self.motor.description}"}
        if isinstance(self.policy, TablePolicy):
            table = self.policy.table
            axes = " × ".join(f"{a.n} of {a.signal} ({a.lo:g} to {a.hi:g})" for a in table.axes)
            facts["table"] = f"{table.values.size} nodes: {axes}"
            known = table.provenance
            if "steps" in known and "seed" in known:
                facts["training"] = f"{known['steps']} decisions, seed {known['seed']}"
        if not self.policy.sensored:
            facts["estimator"] = design_for(self.policy, self.design).estimator
        verdict = Path(self.run) / VERDICT
        if verdict.is_file():
            facts["verdict"] = json.loads(verdict.read_text(encoding="utf-8"))["verdict"]
        facts["compared with"] = ", ".join(self.others)
        return facts

    def _versions(self, results: Results) -> dict[str, str]:
        out = {**results.versions, "matplotlib": version("matplotlib")}
        if isinstance(self.policy, TablePolicy):
            trained = dict(self.policy.table.provenance.get("versions", {}))
            out |= {f"{name}, in training": str(number) for name, number in trained.items()}
        return out

    def _commands(self, command: str) -> list[tuple[str, str]]:
        out = [("This page:", command)]
        if isinstance(self.policy, TablePolicy) and self.policy.table.provenance.get("command"):
            out.insert(0, ("The policy:", str(self.policy.table.provenance["command"])))
        replay = ("simulate", "--scenario", "SCENARIO", "--policy", self.run, "--plot", "case.png")
        return [*out, ("Any scenario in the tables above:", self._command(*replay))]

    def _command(self, *words: str) -> str:
        return shlex.join(["sensorless", *words, *self.options])
