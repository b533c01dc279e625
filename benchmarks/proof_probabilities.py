"""How often the answers of sealed proofs are right, by the probability that they state, and by that of today's rules.

    python benchmarks/proof_probabilities.py PROOF [PROOF ...]

A PROOF is a folder that `tactiledata prove --out` made and answered, or an archive of it that `--publish` made. Nothing
is named anew: today's rules get the probabilities of each answer, and keep a part of a candidate's for another effect
beside it and for what looks like it (`DecisionThresholds.with_doubt`). Answers that kept such parts already are taken
as they are. The first table counts the likeliest statement of every answer, as the score does; the second one claims of
a fit, which are right where all that they name is hidden, alone or with another effect.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from timing import header, table

from tactiledata.diagnose.answer.sentences import MOST_PROBABLE
from tactiledata.diagnose.naming.decide import probability_of
from tactiledata.diagnose.naming.thresholds import DEFAULT_THRESHOLDS
from tactiledata.prove.score.outcome import CLAIMS
from tactiledata.prove.score.score import calibration, calibration_of
from tactiledata.prove.score.scored_case import BESIDE, NONE, OTHER, ScoredCase
from tactiledata.prove.seal.published import opened_proof
from tactiledata.prove.seal.verify import scored_cases


def with_doubt(case: ScoredCase) -> ScoredCase:
    """A case whose answer states the probabilities of today's rules."""
    told: Mapping[str, float] = case.answer["probabilities"]
    if not told or BESIDE in told:
        return case
    labels = [label for label in told if label not in (NONE, OTHER)]
    shares = np.array([told[label] for label in (*labels, NONE, OTHER)])
    doubted = DEFAULT_THRESHOLDS.with_doubt(shares, [label.split(" + ") for label in labels]).tolist()
    probabilities = dict(zip((*labels, BESIDE, NONE, OTHER), doubted, strict=True))
    return replace(case, answer={**case.answer, "probabilities": probabilities})


def of_claims(cases: Sequence[ScoredCase]) -> Iterator[tuple[float, bool]]:
    """Yield the probability that each claim of a fit states, and whether all that it names is hidden."""
    for case in cases:
        names = case.answer["names"]
        if case.answer["verdict"] in CLAIMS and names:
            stated = probability_of(names, case.answer["probabilities"])
            yield min(stated, MOST_PROBABLE), set(names) <= case.truth


def rows_of(told: Mapping[str, Any]) -> list[tuple[str, int, str, str]]:
    """Rows of a calibration: between which probabilities, statements, their mean probability, share that is right."""
    return [
        (
            "{:g} to {:g}".format(*row["between"]),
            row["count"],
            f"{row['mean_probability']:.2f}",
            f"{row['share_right']:.2f}",
        )
        for row in told["rows"]
    ]


def cost(cases: Sequence[ScoredCase]) -> float:
    """Mean negative logarithm of the probability that the likeliest statement gets if it is right, else of the rest."""
    told = [case.probability for case in cases]
    return float(np.mean([-np.log(max(chance if is_right else 1.0 - chance, 1e-3)) for chance, is_right in told]))


def main() -> None:
    """Print both tables, as answered and by today's rules."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("proofs", type=Path, nargs="+")
    cases: list[ScoredCase] = []
    for proof in parser.parse_args().proofs:
        with opened_proof(proof) as folder:
            cases += scored_cases(folder)
    header("probabilities in sealed proofs (simulated recordings)", ("numpy",))
    columns = ("between", "answers", "mean probability", "share that is right")
    for title, of in (("as answered", cases), ("by the rules of today", [with_doubt(case) for case in cases])):
        told = calibration(of)
        print(f"\n{title}: {len(cases)} answers, ECE {told['ece']:.3f}, mean -log p {cost(of):.2f}")
        table(columns, rows_of(told))
        print("claims of a fit, right where all that they name is hidden, alone or with another effect")
        table(("between", "claims", *columns[2:]), rows_of(calibration_of(list(of_claims(of)))))


if __name__ == "__main__":
    main()
