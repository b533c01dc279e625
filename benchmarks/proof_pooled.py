"""The targets of a proof over several sealed proofs that the same rules decided.

    python benchmarks/proof_pooled.py PROOF [PROOF ...]

A PROOF is a folder that `tactiledata prove --out` made and answered. Cases of all are scored together, as those of one
proof are. Where the command of a proof chose what is hidden (``--effects``), only its worlds without effects are taken:
the others are no sample. Nothing is computed anew. Whether the proofs had the same rules is not looked at: the table of
proofs shows their commits. In "over configurations" one of the same name in two proofs counts as one.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from timing import header, table

from tactiledata.prove.cases.kinds import NULLS
from tactiledata.prove.request import ProofRequest
from tactiledata.prove.score.score import met_words, score_of
from tactiledata.prove.score.scored_case import ScoredCase
from tactiledata.prove.score.shares import interval_words
from tactiledata.prove.seal.folder import ProofFolder, read_json
from tactiledata.prove.seal.verify import scored_cases


def pooled(cases: Sequence[ScoredCase], chosen: Sequence[str]) -> list[ScoredCase]:
    """Cases of a proof that take part: of chosen effects only those that hide nothing."""
    return [case for case in cases if not chosen or case.kind == NULLS]


def target_rows(score: Mapping[str, Any]) -> list[tuple[str, ...]]:
    """A row for each target with a case: what, aim, share, both intervals, and whether it is met."""
    return [
        (
            one["what"], one["target"], f"{one['right']} of {one['count']}", interval_words(one["interval"]),
            interval_words(one["over_configurations"]) or "-", met_words(one),
        )
        for one in score["targets"]
        if one["count"]
    ]  # fmt: skip


def strength_rows(score: Mapping[str, Any]) -> list[tuple[str, ...]]:
    """A row for each range of signals: its ends, and how many single effects are named, and named or in the set."""
    rows = []
    for one in score["strength"]:
        low, high = one["signal"]
        ends = f"{low:.0f} to {high:.0f}" if high is not None else f"{low:.0f} and more"
        rows.append((ends, *(f"{one[key]['right']} of {one[key]['count']}" for key in ("named", "named_or_in_set"))))
    return rows


def other_rows(score: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Rows of what is no share: size of the set, error of the probabilities, material, gap."""
    rows = [("effects in the set of named single effects, mean", f"{score['mean_set']}")]
    rows.append(("error of the probabilities (ECE), all cases", f"{score['probabilities']['ece']}"))
    if score["material"]:
        for side, words in (("before", "without"), ("after", "with")):
            listed = ", ".join(f"{value:.1f}" for value in score["material"][side])
            rows.append((f"median error of E, nu, mu {words} what is named, %", listed))
    if score["gap_closed"]:
        rows.append(("gap closed on held-out indenters, median, rightly named", f"{score['gap_closed']['share']:.2f}"))
    return rows


def main() -> None:
    """Print the proofs, the targets and what single effects of each signal were answered."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("proofs", type=Path, nargs="+")
    cases: list[ScoredCase] = []
    rows = []
    for path in parser.parse_args().proofs:
        folder = ProofFolder(path)
        request, seal = ProofRequest.of(read_json(folder.proof)["request"]), read_json(folder.seal)
        answered = scored_cases(folder)
        taken = pooled(answered, request.only)
        cases += taken
        rows.append((path.name, seal["tool"]["commit"][:8], seal["root"][:8], f"{len(taken)} of {len(answered)}"))
    header("the targets over several sealed proofs (simulated recordings)", ("numpy",))
    table(("proof", "sealed at", "root", "cases taken"), rows)
    score = score_of(cases)
    table(("what", "target", "found", "95 % interval", "over configurations", ""), target_rows(score))
    table(("signal of single effects", "named", "named or in the set"), strength_rows(score))
    table(("what", "found"), other_rows(score))


if __name__ == "__main__":
    main()
