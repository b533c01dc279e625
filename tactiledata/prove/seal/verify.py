"""A proof checked without any simulator: commitments, root, cases, answers, attempts, thresholds and the score."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from tactiledata.contract.provenance import digest_of, file_digest
from tactiledata.errors import StoreError, TactileDataError, UsageError
from tactiledata.prove.score.score import score_of
from tactiledata.prove.score.scored_case import ScoredCase
from tactiledata.prove.seal.folder import FORMAT, ProofFolder, last_answer, read_json, read_sealed
from tactiledata.prove.seal.frozen import changed_numbers, frozen_tool, tool_digest
from tactiledata.prove.seal.leak import leak_of
from tactiledata.prove.seal.merkle import commitment, root_of


@dataclass(frozen=True)
class Verification:
    """What a check of a proof found.

    Parameters
    ----------
    faults : tuple of str
        What does not fit, in sentences; empty where all fits.
    notes : tuple of str
        What a reader should know: attempts without an answer, reruns, cases without an answer, another installation.
    cases, answers : int
        Number of cases and of answers that count.
    root : str
        The Merkle root of the sealed cases.
    score : dict, optional
        The score as it follows from labels and answers; ``None`` where something is missing.
    """

    faults: tuple[str, ...]
    notes: tuple[str, ...]
    cases: int
    answers: int
    root: str
    score: Mapping[str, Any] | None

    @property
    def document(self) -> dict[str, Any]:
        """The findings for machines."""
        return {
            "is_whole": not self.faults,
            "faults": list(self.faults),
            "notes": list(self.notes),
            "cases": self.cases,
            "answers": self.answers,
            "root": self.root,
            "score": None if self.score is None else dict(self.score),
        }


def scored_cases(folder: ProofFolder) -> list[ScoredCase]:
    """Return all cases with an answer, by name; of several answers the last one."""
    labels: dict[str, Any] = read_json(folder.labels)
    found = []
    for name in sorted(labels):
        answer = last_answer(folder, name)
        if answer is not None:
            found.append(ScoredCase(name, labels[name]["label"], answer["answer"], float(answer["seconds"])))
    return found


def answers_root(folder: ProofFolder, names: list[str]) -> str:
    """Return the Merkle root of all answers to cases, reruns included."""
    return root_of({
        f"{name}-{number}": file_digest(folder.answer(name, number))
        for name in names
        for number in folder.answers_of(name)
    })  # fmt: skip


def verify(folder: ProofFolder, published: str | None = None, look_for_leaks: bool = False) -> Verification:
    """Return whether a proof is as it was sealed and answered; what was changed is said, file by file.

    Parameters
    ----------
    folder : ProofFolder
        The folder of the proof.
    published : str, optional
        The root that was published before the answers. Without it, nobody can know whether everything was sealed anew.
    look_for_leaks : bool
        Whether a classifier tries to tell kinds of cases from names, sizes, stamps and order.

    Raises
    ------
    TactileDataError
        The folder holds no proof, or a file of it cannot be read at all.
    """
    faults: list[str] = []
    notes: list[str] = []
    seal, is_whole = read_sealed(folder.seal)
    need_seal(folder, seal)
    if not is_whole:
        faults.append("seal.json is not as it was written: its digest does not fit its bytes.")
    if published is not None and published != seal["root"]:
        faults.append(f"The root is {seal['root']}; published was {published}: the cases were sealed anew.")
    labels: dict[str, Any] = read_json(folder.labels)
    if not isinstance(labels, dict):
        raise StoreError(f"{folder.labels} holds no labels by name", "labels and salts", "Restore it from a copy.")
    cases: dict[str, Any] = seal["cases"]
    faults += _label_faults(labels, cases) + _case_faults(folder, seal)
    if digest_of(read_json(folder.proof)) != seal["request_sha256"]:
        faults.append("proof.json is not what was asked when the proof was sealed.")
    faults += _tool_faults(seal["tool"])
    now = frozen_tool()
    if now["digest"] != seal["tool"]["digest"]:
        numbers = changed_numbers(seal["tool"], now)
        told = f": {'; '.join(numbers[:5])}" if numbers else ", in its program"
        notes.append(f"The tool that is installed here is not the one that was sealed{told}.")
    answer_faults, answer_notes = _answer_faults(folder, seal)
    faults += answer_faults
    notes += answer_notes
    score = None
    answered = [name for name in cases if folder.answers_of(name)]
    try:
        score = score_of(scored_cases(folder))
    except (KeyError, TypeError, ValueError, TactileDataError) as error:
        faults.append(f"No score follows from labels and answers: {type(error).__name__} {error}.")
    faults += _score_faults(folder, score, seal)
    if folder.is_published:
        notes.append("Readings are not in the archive: whether they fit their digests was not looked at.")
    elif look_for_leaks and not faults:
        notes += _leak_notes(folder)
    return Verification(tuple(faults), tuple(notes), len(cases), len(answered), str(seal["root"]), score)


def need_seal(folder: ProofFolder, seal: Mapping[str, Any]) -> None:
    """Refuse a document that is no seal of a proof.

    Raises
    ------
    StoreError
        Fields are missing, or have other types than a seal's.
    """
    cases, tool = seal.get("cases"), seal.get("tool")
    fields = ("commitment", "readings_sha256", "plan")
    whole = isinstance(cases, dict) and all(
        isinstance(one, dict) and all(isinstance(one.get(field), str) for field in fields) for one in cases.values()
    )
    if seal.get("format") != FORMAT or not whole or not isinstance(tool, dict) or "digest" not in tool:
        raise StoreError(f"{folder.seal} is no seal", f"a seal of format {FORMAT}", "Restore it from a copy.")
    numbers = tool.get("numbers", {})
    if not isinstance(numbers, dict) or not all(isinstance(group, dict) for group in numbers.values()):
        raise StoreError(f"{folder.seal} has no numbers by groups", "thresholds of the tool", "Restore it from a copy.")
    for field in ("root", "request_sha256"):
        if field not in seal:
            raise StoreError(f"{folder.seal} has no field {field!r}", "a seal", "Restore it from a copy.")


def _leak_notes(folder: ProofFolder) -> list[str]:
    """Return in a sentence whether anything but the readings tells the kinds of cases."""
    try:
        return [leak_of(folder).sentence]
    except UsageError as error:
        return [f"Leaks were not looked for: {error.found}."]


def _label_faults(labels: Mapping[str, Any], cases: Mapping[str, Any]) -> list[str]:
    """Return which labels do not fit their commitments."""
    faults = [f"The label of case {name} is missing from sealed/labels.json." for name in cases if name not in labels]
    faults += [f"sealed/labels.json has a case {name} that was not sealed." for name in labels if name not in cases]
    for name in sorted({*labels} & {*cases}):
        try:
            fits = commitment(labels[name]["salt"], labels[name]["label"]) == cases[name]["commitment"]
        except (KeyError, TypeError, ValueError):
            fits = False
        if not fits:
            faults.append(f"The label or the salt of case {name} was changed: it does not fit its commitment.")
    return faults


def _case_faults(folder: ProofFolder, seal: Mapping[str, Any]) -> list[str]:
    """Return which cases do not fit their digests, and whether all of them fit the root."""
    faults = []
    # a published archive has no readings: the root has their digests all the same
    for name, one in () if folder.is_published else sorted(seal["cases"].items()):
        path = folder.case(name)
        if not path.is_file():
            faults.append(f"The readings of case {name} are missing.")
        elif file_digest(path) != one["readings_sha256"]:
            faults.append(f"The readings of case {name} were changed.")
    entries = {name: f"{one['commitment']} {one['readings_sha256']}" for name, one in seal["cases"].items()}
    if root_of(entries) != seal["root"]:
        faults.append("The root in seal.json does not follow from its commitments and digests.")
    return faults


def _tool_faults(tool: Mapping[str, Any]) -> list[str]:
    """Return whether the numbers in the seal are those whose digest was sealed."""
    if tool_digest(tool) == tool.get("digest"):
        return []
    known = frozen_tool()
    told = changed_numbers(tool, known) if known["digest"] == tool.get("digest") else []
    which = f" {'; '.join(told[:5])}" if told else " Program or thresholds in seal.json"
    return [f"A threshold was changed after the seal:{which} do not fit the digest of the frozen tool."]


def _answer_faults(folder: ProofFolder, seal: Mapping[str, Any]) -> tuple[list[str], list[str]]:
    """Return what is wrong with answers and attempts, and what is to be said of them."""
    faults, notes = [], []
    for name in sorted(seal["cases"]):
        attempts, answers = folder.attempts_of(name), folder.answers_of(name)
        for number in answers:
            document, is_whole = read_sealed(folder.answer(name, number))
            if not is_whole or document.get("case") != name or document.get("attempt") != number:
                faults.append(f"Answer {number} to case {name} was changed.")
            if document.get("tool") != seal["tool"]["digest"]:
                faults.append(f"Answer {number} to case {name} was given by another tool than the one that was sealed.")
            if number not in attempts:
                faults.append(f"Answer {number} to case {name} has no attempt: its file is missing.")
        if not answers:
            notes.append(f"Case {name} has no answer.")
        broken = [number for number in attempts if number not in answers]
        if broken and answers:
            notes.append(f"Case {name} was begun {len(attempts)} times; {len(broken)} of them gave no answer.")
        if len(answers) > 1:
            notes.append(f"Case {name} was answered {len(answers)} times; the last answer counts.")
    strangers = {path.name.rpartition("-")[0] for path in (folder.path / "answers").glob("*.json")} - set(seal["cases"])
    faults += [f"answers/ has an answer to {name!r}, which is no case." for name in sorted(strangers)]
    return faults, notes


def _score_faults(folder: ProofFolder, score: Mapping[str, Any] | None, seal: Mapping[str, Any]) -> list[str]:
    """Return whether the score that is kept follows from labels and answers."""
    if not folder.score.is_file():
        return []
    kept, is_whole = read_sealed(folder.score)
    faults = [] if is_whole else ["score.json is not as it was written: its digest does not fit its bytes."]
    if (kept.get("root"), kept.get("tool")) != (seal["root"], seal["tool"]["digest"]):
        faults.append("score.json is that of other cases, or of another tool: seal.json has other digests of them.")
    if kept.get("answers_root") != answers_root(folder, sorted(seal["cases"])):
        faults.append("The answers are not those that were scored: their root in score.json differs.")
    if score is not None and digest_of(kept.get("score")) != digest_of(score):
        faults.append("The score in score.json does not follow from labels and answers.")
    return faults
