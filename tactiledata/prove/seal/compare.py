"""Two copies of one proof, answered on different machines: how many answers agree, and which do not."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from tactiledata.errors import UsageError
from tactiledata.prove.score.wilson import interval
from tactiledata.prove.seal.folder import ProofFolder, last_answer, read_sealed
from tactiledata.prove.seal.verify import need_seal

COMPARED = {"verdict": "verdict", "names": "named effects", "set": "effects in the set"}
"""Fields of an answer that are compared, with what they are called; the order of effects does not count."""


@dataclass(frozen=True)
class AnswerComparison:
    """Answers to the same sealed cases in two folders.

    Parameters
    ----------
    cases : int
        Number of cases that both folders answer.
    agreed : dict, field -> int
        Number of cases in which a field of ``COMPARED`` is the same.
    differences : tuple of str
        What differs, in a sentence for each case.
    """

    cases: int
    agreed: Mapping[str, int]
    differences: tuple[str, ...]

    @property
    def document(self) -> dict[str, Any]:
        """The comparison for machines; ``interval`` is Wilson's 95 % interval of the share that agrees."""
        return {
            "cases": self.cases,
            "agreed": {
                field: {"count": count, "interval": list(interval(count, self.cases))}
                for field, count in self.agreed.items()
            },
            "differences": list(self.differences),
        }


def compare(folder: ProofFolder, other: ProofFolder) -> AnswerComparison:
    """Return how far two folders agree in their answers to the cases that both of them answer; the last answers count.

    Parameters
    ----------
    folder, other : ProofFolder
        Two copies of one sealed proof.

    Raises
    ------
    UsageError
        The folders hold different proofs, or no case that both answer.
    TactileDataError
        A folder holds no proof, or a file of it cannot be read.
    """
    cases = _sealed_cases(folder, other)
    answers = {name: (last_answer(folder, name), last_answer(other, name)) for name in sorted(cases)}
    both = {name: (one, two) for name, (one, two) in answers.items() if one is not None and two is not None}
    if not both:
        raise UsageError(
            f"no case is answered both in {folder.path} and in {other.path}",
            "two copies of a proof, each with answers",
            "Answer both with `tactiledata prove --out FOLDER`.",
        )
    agreed = dict.fromkeys(COMPARED, 0)
    differences = []
    for name, documents in both.items():
        first, second = (_compared(one, name) for one in documents)
        apart = [field for field in COMPARED if first[field] != second[field]]
        for field in COMPARED:
            agreed[field] += field not in apart
        if apart:
            said = "; ".join(
                f"{COMPARED[field]}: {_told(first[field])} in the first, {_told(second[field])} in the second"
                for field in apart
            )
            differences.append(f"{name}: {said}.")
    return AnswerComparison(len(both), agreed, tuple(differences))


def _sealed_cases(folder: ProofFolder, other: ProofFolder) -> Mapping[str, Any]:
    """Return the cases of a proof of which both folders are copies."""
    seals = []
    for one in (folder, other):
        seal, _ = read_sealed(one.seal)
        need_seal(one, seal)
        seals.append(seal)
    if seals[0]["root"] != seals[1]["root"]:
        raise UsageError(
            f"{folder.path} has the root {seals[0]['root']}, {other.path} has {seals[1]['root']}",
            "two copies of one sealed proof",
            "Copy the folder after it was sealed, and answer its cases on both machines.",
        )
    cases: Mapping[str, Any] = seals[0]["cases"]
    return cases


def _compared(document: Mapping[str, Any], name: str) -> dict[str, Any]:
    """Return the compared fields of an answer to a case, effects in alphabetical order."""
    answer = document.get("answer")
    if not isinstance(answer, dict) or not set(COMPARED) <= set(answer):
        raise UsageError(f"an answer to {name} without {', '.join(COMPARED)}", "answers of `tactiledata prove`")
    return {field: answer[field] if field == "verdict" else sorted(answer[field]) for field in COMPARED}


def _told(value: str | list[str]) -> str:
    """Return a verdict or a list of effects in words."""
    return (" and ".join(value) or "none") if isinstance(value, list) else value
