"""The tasks of a proof that workers run: solve a touch, draw a case, diagnose a case. Each leaves whole files."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tactiledata.contract.atomic import write_atomic, write_json_atomic
from tactiledata.errors import TactileDataError
from tactiledata.prove.answers.case_readings import case_readings
from tactiledata.prove.answers.failed import failed_answer
from tactiledata.prove.answers.named import named_world
from tactiledata.prove.cases.configuration import played_plan
from tactiledata.prove.cases.draw import CaseRequest, drawn_case
from tactiledata.prove.score.outcome import FAILED
from tactiledata.prove.seal.folder import (
    ProofFolder,
    read_json,
    read_sealed,
    readings_bytes,
    write_sealed,
)
from tactiledata.prove.worlds.generators import make_generator
from tactiledata.prove.worlds.logs import play_logs
from tactiledata.prove.worlds.plan_names import named_plan
from tactiledata.rig.bank.bank import ContactBank
from tactiledata.rig.play import RigSetup
from tactiledata.rig.scenario.scenario import load_scenario


@dataclass(frozen=True)
class SolveTask:
    """A touch whose contact a generator solves and keeps, so that worlds of its plan are recorded in seconds.

    Parameters
    ----------
    generator : str
        Name of the generator.
    plan : str
        Name of the plan of touches.
    touch : str
        Name of the touch.
    bank : Path
        Folder of kept solutions.
    """

    generator: str
    plan: str
    touch: str
    bank: Path


@dataclass(frozen=True)
class DrawTask:
    """A case that is to be drawn and kept.

    Parameters
    ----------
    folder : ProofFolder
        Where the case is kept.
    request : CaseRequest
        The case.
    """

    folder: ProofFolder
    request: CaseRequest


@dataclass(frozen=True)
class AnswerTask:
    """A case that is to be diagnosed: what the diagnosis is told of it, and no more.

    Parameters
    ----------
    folder : ProofFolder
        Where the case lies and the answer is kept.
    name : str
        Random name of the case.
    attempt : int
        Number of the attempt, from 1.
    plan : str
        Name of the plan of touches.
    bank : Path
        Folder of kept solutions; a plan is laid out with it, and a diagnosis solves nothing there.
    tool : str
        Digest of the frozen tool.
    with_variants, pairs, in_full : bool
        See `ProofRequest`.
    """

    folder: ProofFolder
    name: str
    attempt: int
    plan: str
    bank: Path
    tool: str
    with_variants: bool
    pairs: bool
    in_full: bool


def solve(task: SolveTask) -> None:
    """Solve one touch of a plan, as a world without hidden effects needs it."""
    plan = named_plan(task.plan)
    document = plan.scenario(0, plan.truth, [])
    touch = next(touch for touch in document["trajectories"] if touch["name"] == task.touch)
    sensor = {touch["sensor"]: document["sensors"][touch["sensor"]]}
    scenario = load_scenario({**document, "sensors": sensor, "trajectories": [touch]})
    bank = ContactBank(task.bank, plan.pitch, RigSetup(scenario).indenters)
    play_logs(scenario, make_generator(task.generator, bank))


def draw(task: DrawTask) -> dict[str, Any]:
    """Draw a case, or read the one that was drawn before; return its document without readings."""
    folder, number = task.folder, task.request.number
    if folder.draw(number).exists():
        kept: dict[str, Any] = read_json(folder.draw(number))
        return kept
    drawn = drawn_case(task.request)
    document = {
        "number": number,
        "kind": task.request.kind,
        "rejected": dict(drawn.rejected),
        "label": None if drawn.case is None else drawn.case.document,
    }
    # the readings first: a case whose document is there is whole
    if drawn.case is not None:
        logs = [(one.t_ns, one.values) for one in drawn.readings]
        write_atomic(folder.drawn_readings(number), readings_bytes(logs))
    write_json_atomic(folder.draw(number), document)
    return document


def answer(task: AnswerTask) -> dict[str, Any]:
    """Diagnose a case and keep the answer; return what is printed of it.

    An error that ends the diagnosis is an answer, too (`failed_answer`): the case counts, and others go on.
    A scheduler runs a task again whose worker was lost: an answer that was kept before is not given again, and an
    attempt that gave none is counted.
    """
    folder = task.folder
    answered = [number for number in folder.answers_of(task.name) if number >= task.attempt]
    if answered:
        return _printed(read_sealed(folder.answer(task.name, answered[-1]))[0])
    attempt = max([task.attempt - 1, *folder.attempts_of(task.name)]) + 1
    began = {"case": task.name, "attempt": attempt, "tool": task.tool}
    write_json_atomic(folder.attempt(task.name, attempt), began)
    readings = case_readings(folder, task.name)
    played = played_plan(task.plan, task.bank, task.with_variants)
    started = time.perf_counter()
    try:
        found = named_world(played, readings, task.pairs, task.in_full).document
    except TactileDataError as error:
        found = failed_answer(error)
    document = {**began, "seconds": round(time.perf_counter() - started, 2), "answer": found}
    write_sealed(folder.answer(task.name, attempt), document)
    return _printed(document)


def _printed(document: dict[str, Any]) -> dict[str, Any]:
    """Return what is printed of an answer."""
    found = document["answer"]
    why = found["objections"][0] if found["verdict"] == FAILED else "no name"
    said = ", ".join(found["set"]) or why
    return {"case": document["case"], "verdict": found["verdict"], "said": said, "seconds": document["seconds"]}
