"""The page of a proof: what was asked, what it comes to, and every miss."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from tactiledata.contract.atomic import write_atomic
from tactiledata.contract.simulated import SimulatedCount
from tactiledata.contract.wording import counted
from tactiledata.prove.score.score import met_words, signal_words
from tactiledata.prove.score.shares import interval_words
from tactiledata.prove.seal.folder import ProofFolder, read_json
from tactiledata.report.page import Section, render_page


def write_page(folder: ProofFolder) -> None:
    """Write ``report.html`` of a proof that has a score."""
    seal, score = read_json(folder.seal), read_json(folder.score)
    write_atomic(folder.page, proof_page(seal, score["score"], read_json(folder.proof)).encode())


def proof_page(seal: Mapping[str, Any], score: Mapping[str, Any], proof: Mapping[str, Any]) -> str:
    """Return the page as HTML.

    Parameters
    ----------
    seal : dict
        The seal.
    score : dict
        The score.
    proof : dict
        What was asked.
    """
    tool = seal["tool"]
    changed = ", with changes that are not committed" if tool["is_changed"] else ""
    sentences = [
        f"{counted(score['cases'], 'case')} of {len(seal['cases'])} are answered. Labels were sealed before the first"
        " answer.",
        f"Root of the seal: {seal['root']}.",
        f"Tool: version {tool['version']}, commit {tool['commit'] or 'unknown'}{changed}.",
    ]
    if seal["left_out"]:
        listed = ", ".join(f"{count} {kind}" for kind, count in seal["left_out"].items())
        sentences.append(f"Left out, since no draw was of the kind: {listed}.")
    targets = [
        ("info", "A case is a simulated world. Some worlds hide effects that the simulation lacks, and nulls hide "
                 "nothing. An effect is concealed where a calibration makes up for it. The set holds the named effect "
                 "and those that the recordings cannot tell from it."),
        ("info", "The 95 % interval treats all cases alike. That over configurations draws whole configurations anew."),
    ]  # fmt: skip
    misses = [("", sentence) for sentence in score["misses"]] or [("", "None.")]
    details = [
        Section("Outcomes by configuration", [("info", "How many cases of each kind had which outcome.")],
                columns=_columns("configuration: kind", score["by_configuration"]),
                rows=_rows(score["by_configuration"])),
        Section("Outcomes by what is hidden", columns=_columns("hidden", score["by_effect"]),
                rows=_rows(score["by_effect"])),
        Section("Single effects, seen and concealed", columns=_columns("effect", score["by_concealment"]),
                rows=_rows(score["by_concealment"])),
        Section("Which effect was named instead of which",
                [("info", "A row is what a case hides, a column what the diagnosis named.")],
                columns=_columns("hidden", score["confusion"]), rows=_rows(score["confusion"])),
        Section("Strength and accuracy", [("info", "The signal is what a refit leaves of an effect, over the noise.")],
                columns=["signal", "named", "named or in the set", "detected"],
                rows=[_strength_row(one) for one in score["strength"]]),
        Section("Probabilities", [("", _calibration_words(score))],
                columns=["probability", "answers", "mean probability", "share that is right"],
                rows=[_chance_row(one) for one in score["probabilities"]["rows"]]),
        Section("E, nu and mu", [("", _material_words(score["material"]))]),
        Section("Gap", [("", _gap_words(score["gap_closed"]))]),
        Section("What was asked", code=[json.dumps(proof["request"], indent=1)]),
    ]  # fmt: skip
    sections = [
        Section("Targets", targets, ["what", "target", "found", "95 % interval", "over configurations", "verdict"],
                [_target_row(one) for one in score["targets"]]),
        Section("Every miss", misses),
        *(replace(section, is_folded=True) for section in details),
    ]  # fmt: skip
    simulated = SimulatedCount(simulated=len(seal["cases"]))
    return render_page("A proof of the diagnosis", sentences, sections, "tactiledata prove", simulated)


def _target_row(one: Mapping[str, Any]) -> list[object]:
    """Return the row of a target."""
    if not one["count"]:
        return [one["what"], one["target"], "", "", "", "no case"]
    return [
        one["what"], one["target"], f"{one['right']} of {one['count']}", interval_words(one["interval"]),
        interval_words(one["over_configurations"]), met_words(one),
    ]  # fmt: skip


def _columns(first: str, table: Mapping[str, Mapping[str, int]]) -> list[str]:
    """Return the columns of a table of counts."""
    return [first, *sorted({name for row in table.values() for name in row})]


def _rows(table: Mapping[str, Mapping[str, int]]) -> list[list[object]]:
    """Return the rows of a table of counts; empty cells where nothing is counted."""
    names = _columns("", table)[1:]
    return [[where, *(row.get(name, "") for name in names)] for where, row in table.items()]


def _strength_row(one: Mapping[str, Any]) -> list[object]:
    """Return a row of strength and accuracy."""
    shares = [one[key] for key in ("named", "named_or_in_set", "detected")]
    cells = [f"{each['right']} of {each['count']} ({interval_words(each['interval'])})" for each in shares]
    return [signal_words(*one["signal"]), *cells]


def _chance_row(one: Mapping[str, Any]) -> list[object]:
    """Return a row of probabilities."""
    low, high = one["between"]
    return [f"{low:g} to {high:g}", one["count"], f"{one['mean_probability']:.2f}", f"{one['share_right']:.2f}"]


def _calibration_words(score: Mapping[str, Any]) -> str:
    """Return the error of probabilities in words."""
    error = score["probabilities"]["ece"]
    if error is None:
        return "No answer has probabilities."
    return (
        f"Expected calibration error: {error:.3f}. It is the mean difference between stated probabilities and shares"
        " that are right; 0 is best."
    )


def _gap_words(found: Mapping[str, Any] | None) -> str:
    """Return in words which share of the excess over the noise is gone."""
    if found is None:
        return "No effect was named rightly."
    return (
        f"{100 * found['share']:.0f} % of the excess over the noise is gone on indenters that were held out: the median"
        f" over {counted(found['count'], 'case')} that a fit named rightly."
    )


def _material_words(found: Mapping[str, Any] | None) -> str:
    """Return errors of E, nu and mu in words."""
    if found is None:
        return "No single effect was named rightly."
    before, after = (", ".join(f"{value:.1f}" for value in found[when]) for when in ("before", "after"))
    return (
        "E is the stiffness of the gel, nu its Poisson's ratio, mu its friction. Their median errors over "
        f"{counted(found['count'], 'effect')} named rightly: {before} % by the plain fit, {after} % with the effect."
    )
