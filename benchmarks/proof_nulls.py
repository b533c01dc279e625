"""How near the nulls of a sealed proof come to a name: evidence of false candidates over what a claim needs.

    python benchmarks/proof_nulls.py PROOF [PROOF ...]

A PROOF is a folder that `tactiledata prove --out` made and answered. Printed are, for each world that hides nothing,
the three candidates whose evidence is the largest share of what errors of the simulation can bring; then the largest
share of every single effect over all nulls, and the share of what is hidden in every world where it was missed.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from timing import table

from tactiledata.prove.cases.kinds import NULLS
from tactiledata.prove.seal.folder import ProofFolder
from tactiledata.prove.seal.verify import scored_cases

SHOWN = 3
"""Number of candidates of each null."""


def shares(candidates: Sequence[Mapping[str, Any]]) -> list[tuple[float, str]]:
    """Evidence of each candidate over what a claim of it needs, with its effects; the largest first."""
    found = [(one["evidence"] / one["needed"], " + ".join(one["effects"])) for one in candidates]
    return sorted(found, reverse=True)


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("proofs", type=Path, nargs="+")
    cases = [case for proof in parser.parse_args().proofs for case in scored_cases(ProofFolder(proof))]
    nulls: list[tuple[str, ...]] = []
    missed: list[tuple[str, ...]] = []
    largest: dict[str, float] = {}
    for case in cases:
        ranked = shares(case.answer["candidates"])
        if case.kind == NULLS:
            nulls.append(
                (case.name, case.configuration, ", ".join(f"{share:.2f} {who}" for share, who in ranked[:SHOWN]))
            )
            for share, who in ranked:
                if " + " not in who:
                    largest[who] = max(share, largest.get(who, share))
        elif not case.truth <= set(case.said):
            missed += [(case.name, case.hidden, f"{share:.2f}") for share, who in ranked if {who} == case.truth]
    table(("null", "configuration", "share of what is needed"), nulls)
    table(("effect", "largest share in nulls"), [(who, f"{share:.2f}") for who, share in sorted(largest.items())])
    table(("missed", "hidden", "its share"), missed)


if __name__ == "__main__":
    main()
