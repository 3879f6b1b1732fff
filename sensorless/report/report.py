"""Judges a policy and writes one HTML page about it."""

import shlex
from collections.abc import Collection, Sequence
from dataclasses import asdict
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from sensorless.agents.loading import verdict_of
from sensorless.baselines.linear import eq25_band, linear_table
from sensorless.design.carried import commands_of
from sensorless.evaluation.evaluate import PolicyProgress
from sensorless.evaluation.results import Results
from sensorless.evaluation.trace import trace
from sensorless.files import check_folder, ensure_writable, write_atomic
from sensorless.machine.motor import Motor
from sensorless.plots.envelope import SHOWN
from sensorless.plots.schedule import sheets
from sensorless.plots.wave import wave
from sensorless.policies import shipped
from sensorless.policies.bench import Bench
from sensorless.policy import TablePolicy, design_for
from sensorless.report import maps, tables
from sensorless.report.cases import Case, cases
from sensorless.report.control import other_control
from sensorless.report.folder import PAGE, keep_other_files, results_file
from sensorless.report.judged import case_of, judged, on_its_machine
from sensorless.report.learning import learning
from sensorless.report.page import UPLOT, render
from sensorless.report.verdict import (
    LEAST,
    PLAIN,
    Verdict,
    balance,
    best_rule,
    contrasts_of,
    feasible,
    verdict,
)
from sensorless.report.waves import packed

SUITES = ("stress-1", "handoff")
PAPER = "sliding_mode"
"""Eq. 25 on the paper's observers."""
OPEN = 5
"""Policies that tables show at first."""
SHEET = (65, 51)
"""Points of a map of weights along its axes."""


class Report:
    """Writes a report about one policy.

    Parameters
    ----------
    run : str
        Policy that the report is about, as in ``sensorless.policies.registry.known``.
    bench : Bench
        Machine and drive.
    others : sequence of str, optional
        Policies to compare with; by default Eq. 25 on the paper's observers, every shipped rule
        that was tuned for this motor, and the bounds. Eq. 25 on the design's observer is always
        there, as an export compares with it, too; waveforms are beside it.
    options : sequence of str
        Words of the command line for this motor and design.
    progress : optional
        Called with the name of what is evaluated and the share done.

    Raises
    ------
    UserError
        A policy does not exist.
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
        self.run, self.bench = run, bench
        self.motor, self.design = bench.motor, bench.design
        self.options, self.progress = options, progress
        wanted = others or (PAPER, PLAIN, *_tuned(self.motor), "oracle", "sensored")
        if PLAIN not in wanted:
            wanted = (PLAIN, *wanted)
        self.others = [word for word in wanted if word != run] or [PAPER]
        self.plain = PLAIN if PLAIN in self.others else self.others[0]
        self.policy, self.reference = bench.policy(run), bench.policy(self.plain)

    def write(
        self, folder: Path, suites: Sequence[str], seed: int, size: int, grid: int, command: str
    ) -> tuple[Path, Verdict]:
        """Judge and write; return page and verdict. Every file is written whole or not at all.

        Parameters
        ----------
        folder : Path
            Created, when all is judged, if it does not exist.
        suites : sequence of str
            Suites to judge on, ``size`` scenarios each.
        grid : int
            Points of the envelope maps along each axis.
        command : str
            Command that the user typed, for the page.

        Raises
        ------
        UserError
            A file of the run is damaged, found before anything is judged, or the folder cannot be
            written to or has a page or results that are no report's.
        """
        check_folder(folder)
        keep_other_files(folder, suites)
        about = self._about()
        panels, about_panels = learning(self.run)
        words = [self.run, *self.others]
        results = [self._evaluate(name, seed, size, words) for name in suites]
        apart = other_control(self.bench, suites, seed, size, words)
        rivals = self._rivals(results[0], apart)
        contrasts = contrasts_of(results, rivals, apart)
        said = verdict(results, contrasts, isinstance(self.policy, TablePolicy))
        said = on_its_machine(said, self.policy, self.bench, self.progress)
        beside = self._beside(rivals)
        own, shown = self.policy.name, self._shown(results[0], rivals)
        chosen = {c.scenario: c for r in results for c in cases(r, own, self.reference.name)}
        named = dict(zip(results[0].policies, words, strict=True))
        mapped = [named[n] for n in (own, *rivals)]
        over = self._evaluate("envelope", seed, grid * grid, mapped)
        drawn = {f"envelope {m.title}": m for m in maps.envelope(over, self.motor, SHOWN)}
        table = {f"table {m.title} {m.note}": m for m in self._table()}
        page = render(
            "report.html.j2",
            {
                "maps": {key: m.packed() for key, m in {**drawn, **table}.items()},
                "cases": {w: self._waves(case, len(chosen)) for w, case in chosen.items()},
                "curves": panels,
            },
            name=own,
            motor=f"{self.motor.name}, {self.motor.description}",
            verdict=said,
            contrasts=contrasts_of(results, beside, apart),
            balance=balance(results[0], [name for name in rivals if name not in apart]),
            basis=self._basis(results),
            least=f"{LEAST:g}",
            sections=[self._section(r, shown, [own, *beside], apart) for r in results],
            shown=shown,
            columns=[heading for _, heading, _, _ in tables.COLUMNS],
            place_columns=[heading for _, heading, _, _ in tables.PLACE_COLUMNS],
            sides=[own, *beside],
            fails=[*(tables.said(r, own) for r in results), tables.held(over, self.motor)],
            envelope=list(drawn),
            most=SHOWN,
            cases=list(chosen.values()),
            sheets=list(table),
            curves=[panel["label"] for panel in panels],
            learning=about_panels,
            about=about,
            commands=self._commands(command, results, mapped, grid * grid),
            versions=self._versions(results[0]),
            design=asdict(design_for(self.policy, self.design)),
            formulas=tables.formulas(),
            uplot=UPLOT,
        )
        ensure_writable(folder)
        for result in results:
            result.write(results_file(folder, result.suite), scenarios=False)
        write_atomic(folder / PAGE, page)
        return folder / PAGE, said

    def _rivals(self, results: Results, apart: Collection[str]) -> list[str]:
        """Names of Eq. 25, or else the first other policy, and of the best tuned rule."""
        best = best_rule(results, self.others, apart)
        return list(dict.fromkeys(filter(None, (self.reference.name, best))))

    def _beside(self, rivals: Sequence[str]) -> list[str]:
        """Rivals, and the paper's rule on the paper's observers where it is on others too."""
        paper = [PAPER] if PLAIN in rivals and PAPER in self.others else []
        return list(dict.fromkeys([*rivals, *paper]))

    def _shown(self, results: Results, rivals: Sequence[str]) -> list[str]:
        bounds = [name for name, p in results.policies.items() if p["bound"]][-1:]
        first = [self.policy.name, *rivals, *bounds]
        rest = [name for name in results.policies if name not in first]
        chosen = {*first, *rest[: max(0, OPEN - len(first))]}
        return [*[n for n in first if n not in bounds], *[n for n in rest if n in chosen], *bounds]

    def _evaluate(self, suite: str, seed: int, size: int, policies: Sequence[str]) -> Results:
        def report(name: str, done: float) -> None:
            if self.progress is not None:
                self.progress(f"{suite}: {name}", done)

        return judged(self.bench, suite, seed, size, policies, report)

    def _section(
        self, results: Results, shown: Sequence[str], sides: Sequence[str], apart: Collection[str]
    ) -> dict[str, Any]:
        return {
            "suite": results.suite,
            "setting": f"seed {results.seed}, {results.count} scenarios",
            "rows": tables.result_rows(results, shown),
            "pairs": tables.pair_rows(results, shown, apart),
            "places": tables.place_rows(results, sides),
            "machines": tables.machine_rows(results, sides),
        }

    def _basis(self, results: Sequence[Results]) -> str:
        first = results[0].policies[self.policy.name]
        there = f"; {PAPER} is that rule on the paper’s observers" if PAPER in self.others else ""
        return (
            f"Simulated on {' and '.join(map(_drawn, results))}. "
            f"{feasible(results[0], first)} scenarios of {results[0].suite} bound its lost rate to "
            f"{100.0 * first['lost_ci'][1]:.1f} % at most (95 %); sensorless certify bounds it "
            "closer. Eq. 25 is the linear rule of the source paper, here on the drive’s default "
            f"estimator{there}."
        )

    def _waves(self, case: Case, count: int) -> list[dict[str, Any]]:
        bench, scenario = case_of(self.bench, case.scenario)
        runs = {
            policy.name: trace(policy, scenario, bench.motor, bench.design, go_on=True)
            for policy in bench.policies((self.run, self.plain)).values()
        }
        return [packed(wave(f"{case.scenario} under {n}", run), count) for n, run in runs.items()]

    def _table(self) -> list[maps.Map]:
        if not isinstance(self.policy, TablePolicy):
            return []
        eq25 = linear_table(*eq25_band(self.motor))
        return maps.schedule(sheets(self.policy.name, self.policy.table, eq25, self.motor, *SHEET))

    def _about(self) -> dict[str, str]:
        facts = {"policy": self.run}
        if isinstance(self.policy, TablePolicy):
            table = self.policy.table
            axes = " × ".join(f"{a.n} of {a.signal} ({a.lo:g} to {a.hi:g})" for a in table.axes)
            facts["table"] = f"{table.values.size} nodes: {axes}"
            known = table.provenance
            if "steps" in known and "seed" in known:
                facts["training"] = f"{known['steps']} decisions, seed {known['seed']}"
        if not self.policy.sensored:
            facts["estimator"] = design_for(self.policy, self.design).estimator
        said = verdict_of(Path(self.run))
        if said is not None:
            facts["after training"] = said
        return facts

    def _versions(self, results: Results) -> dict[str, str]:
        out = dict(results.versions)
        if isinstance(self.policy, TablePolicy):
            trained = dict(self.policy.table.provenance.get("versions", {}))
            out |= {f"{name}, in training": str(number) for name, number in trained.items()}
        return out

    def _commands(
        self, command: str, results: Sequence[Results], mapped: Sequence[str], points: int
    ) -> list[tuple[str, str]]:
        out = [("This page:", command)]
        if isinstance(self.policy, TablePolicy):
            made = commands_of(self.policy.table.provenance)
            names = ("The policy:", *["And then:"] * (len(made) - 1))
            out = [*zip(names, made, strict=False), *out]
        judged, sides = (
            [word for name in names for word in ("--policy", name)]
            for names in ((self.run, *self.others), mapped)
        )
        for r in results:
            setting = ["--suite", r.suite, "--seed", str(r.seed), "--size", str(r.size)]
            again = self._command("evaluate", *judged, *setting, "--details")
            out.append((f"The results of {r.suite}:", again))
        grid = ["--suite", "envelope", "--seed", str(results[0].seed), "--size", str(points)]
        replay = ("simulate", "--scenario", "SCENARIO", "--policy", self.run, "--plot", "case.html")
        return [
            *out,
            ("The map over speed and load:", self._command("evaluate", *sides, *grid)),
            ("Any scenario of the tables:", self._command(*replay)),
        ]

    def _command(self, *words: str) -> str:
        return shlex.join(["sensorless", *words, *self.options])


def _tuned(motor: Motor) -> list[str]:
    """Shipped tuned rules that were tuned for this machine, of the libraries installed here.

    Fuzzy ones need simpful.
    """
    if motor.digest != Motor.load("paper").digest:
        return []
    fuzzy = find_spec("simpful") is not None
    return [name for name in shipped.tuned_names() if fuzzy or not name.startswith("fuzzy")]


def _drawn(results: Results) -> str:
    text = f"{results.count} scenarios of {results.suite}"
    return text if results.count == results.size else f"{text} ({results.size} random ones)"
