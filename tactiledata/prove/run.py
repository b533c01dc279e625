"""A proof from its request to its score, step by step; the same call goes on where it was killed."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tactiledata.compute.base import Scheduler
from tactiledata.compute.local import LocalScheduler
from tactiledata.contract.atomic import write_json_atomic
from tactiledata.contract.progress import Progress, no_progress
from tactiledata.errors import TactileDataError, UsageError
from tactiledata.prove.answers.tasks import AnswerTask, DrawTask, SolveTask, answer, draw, solve
from tactiledata.prove.request import ProofRequest
from tactiledata.prove.score.score import score_of
from tactiledata.prove.seal.folder import FORMAT, ProofFolder, read_json, write_sealed
from tactiledata.prove.seal.sealing import need_frozen_tool, read_seal, seal_cases
from tactiledata.prove.seal.verify import answers_root, scored_cases
from tactiledata.prove.worlds.plan_names import named_plan
from tactiledata.prove.worlds.played_plan import PlayedPlan
from tactiledata.store.layout.lock import writing_lock


@dataclass(frozen=True)
class ProofRun:
    """A proof that is run.

    Parameters
    ----------
    folder : ProofFolder
        Where everything is kept.
    request : ProofRequest
        What is asked.
    bank : Path
        Folder of kept solutions of generators.
    runner : Scheduler
        Where touches are played, cases drawn and cases diagnosed.
    report_progress : Progress
        Called with how many steps of a stage are done.
    tell : callable
        Called with a sentence where a stage is done, and for each answer.
    """

    folder: ProofFolder
    request: ProofRequest
    bank: Path
    runner: Scheduler = field(default_factory=LocalScheduler)
    report_progress: Progress = no_progress
    tell: Callable[[str], None] = lambda sentence: None

    def run(self, again: Sequence[str] = ()) -> dict[str, Any]:
        """Return the score; whatever is done already is not done again.

        Parameters
        ----------
        again : sequence of str
            Names of cases that are diagnosed once more; the earlier answers stay, and are listed.
        """
        self.ask()
        with writing_lock(self.folder.path):
            self.play()
            seal = self.seal()
            need_frozen_tool(seal)
            self.answer(seal, again)
            return self.score()

    def run_until_sealed(self) -> dict[str, Any]:
        """Play, draw and seal, and diagnose nothing; return the seal, whose root can then be published.

        A later `run` with the same folder gives the answers.
        """
        self.ask()
        with writing_lock(self.folder.path):
            self.play()
            return self.seal()

    def ask(self) -> None:
        """Write what is asked; refuse a folder in which something else was asked."""
        document = {"format": FORMAT, "request": self.request.document}
        if self.folder.proof.exists():
            kept = read_json(self.folder.proof)
            if kept != document:
                raise UsageError(
                    f"{self.folder.path} holds a proof of another request",
                    "the same options as at its beginning",
                    "Name another folder, or leave all options out to go on.",
                )
            return
        # hidden files are what a killed process was still writing, or another one that begins at this moment writes
        if self.folder.path.exists() and any(place.name[0] != "." for place in self.folder.path.iterdir()):
            raise UsageError(
                f"{self.folder.path} holds other files", "an empty folder, or one with a proof", "Name another folder."
            )
        write_json_atomic(self.folder.proof, document)

    def play(self) -> None:
        """Play the touches of all plans; drawing and diagnosing read the plays from disk."""
        for name in self.request.plans:
            PlayedPlan.of(
                named_plan(name), self.bank, self.request.with_variants, runner=self.runner,
                progress=lambda done, total, what="", plan=name: self.report_progress(done, total, f"{plan}: {what}"),
            )  # fmt: skip

    def solve(self) -> None:
        """Solve the touches of all plans by the generators that keep solutions; worlds of a plan share them."""
        tasks = [
            SolveTask(generator, plan, str(touch["name"]), self.bank)
            for plan in self.request.plans
            for generator in self.request.generators
            if generator != "analytic"
            for touch in named_plan(plan).touches
        ]
        for number, outcome in enumerate(self.runner.outcomes(solve, tasks, len(tasks)), start=1):
            _ = outcome.value  # raises the error of a task
            self.report_progress(number, len(tasks), "solving touches by the generators")

    def seal(self) -> dict[str, Any]:
        """Draw all cases and seal them; return the seal."""
        if self.folder.seal.exists():
            return read_seal(self.folder)
        self.solve()
        requests = self.request.requests(self.bank)
        tasks = [DrawTask(self.folder, request) for request in requests]
        drawn = []
        for number, outcome in enumerate(self.runner.outcomes(draw, tasks, len(tasks)), start=1):
            drawn.append(outcome.value)
            self.report_progress(number, len(tasks), "drawing cases")
        found = [one for one in drawn if one["label"] is not None]
        left_out: dict[str, int] = {}
        for one in drawn:
            if one["label"] is None:
                left_out[one["kind"]] = left_out.get(one["kind"], 0) + 1
        if not found:
            raise TactileDataError(
                f"no draw of {len(drawn)} gave a case ({left_out})", "at least one", "Ask for other kinds or effects."
            )
        plans = {str(request.number): request.configuration.plan for request in requests}
        seal = seal_cases(self.folder, found, plans, left_out)
        self.tell(f"{len(found)} cases are sealed. Root: {seal['root']}")
        for kind, count in left_out.items():
            self.tell(f"{count} of kind {kind!r} left out: no draw was of that kind.")
        return seal

    def answer(self, seal: Mapping[str, Any], again: Sequence[str] = ()) -> None:
        """Diagnose every case that has no answer yet, and those that are asked for again."""
        unknown = set(again) - set(seal["cases"])
        if unknown:
            raise UsageError(f"no case is called {sorted(unknown)[0]!r}", "a name in seal.json")
        todo = [name for name in sorted(seal["cases"]) if name in again or not self.folder.answers_of(name)]
        # plan by plan: a process keeps the plays of a plan
        todo.sort(key=lambda name: seal["cases"][name]["plan"])
        tasks = [self._task(seal, name) for name in todo]
        for number, outcome in enumerate(self.runner.outcomes(answer, tasks, len(tasks)), start=1):
            one = outcome.value
            self.tell(f"{one['case']}: {one['verdict']}: {one['said']} ({one['seconds']:.0f} s)")
            self.report_progress(number, len(tasks), "diagnosing cases")

    def _task(self, seal: Mapping[str, Any], name: str) -> AnswerTask:
        """Return the task of diagnosing a case."""
        attempts = [0, *self.folder.attempts_of(name), *self.folder.answers_of(name)]
        return AnswerTask(
            folder=self.folder,
            name=name,
            attempt=max(attempts) + 1,
            plan=seal["cases"][name]["plan"],
            bank=self.bank,
            tool=seal["tool"]["digest"],
            with_variants=self.request.with_variants,
            pairs=self.request.pairs,
            in_full=self.request.in_full,
        )

    def score(self) -> dict[str, Any]:
        """Score all answers and write score.json; return the score."""
        seal = read_seal(self.folder)
        score = score_of(scored_cases(self.folder))
        kept = {
            "format": FORMAT,
            "root": seal["root"],
            "answers_root": answers_root(self.folder, sorted(seal["cases"])),
            "tool": seal["tool"]["digest"],
            "score": score,
        }
        write_sealed(self.folder.score, kept)
        return score
