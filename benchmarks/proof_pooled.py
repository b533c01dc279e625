"""The targets of a proof over several sealed proofs.

    python benchmarks/proof_pooled.py PROOF [PROOF ...] [--picture FILE]
    python benchmarks/proof_pooled.py --write

A PROOF is a folder that `tactiledata prove --out` made and answered, or an archive of it that `--publish` made: those
of the page of the proof lie in docs/proofs. Cases of all are scored together, as those of one proof are. Where the
command of a proof chose what is hidden (``--effects``), only its worlds without effects are taken: the others are no
sample. Nothing is computed anew. Whether the proofs had the same rules is not looked at: the table of proofs shows
their commits. In "over configurations" one of the same name in two proofs counts as one. The picture shows which share
of single effects is named, by signal and generator. With ``--write`` the pages of the proof get what the commands print
that stand on them.
"""

from __future__ import annotations

import argparse
import io
import re
from collections.abc import Mapping, Sequence
from contextlib import redirect_stdout
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from timing import header, table

from tactiledata.prove.cases.kinds import NULLS, OUTSIDE
from tactiledata.prove.request import ProofRequest
from tactiledata.prove.score.score import SIGNALS, met_words, score_of, signal_words
from tactiledata.prove.score.scored_case import ScoredCase
from tactiledata.prove.score.shares import interval_words
from tactiledata.prove.seal.folder import read_json
from tactiledata.prove.seal.published import opened_proof
from tactiledata.prove.seal.verify import scored_cases

TOLD_ALIKE = {"drainage": "relaxation", "warm_relaxation": "relaxation"}
"""Effects outside the catalogue, with the effect whose answer says that they would be given its name.

The words are those of ``unlisted_look_alike`` of the effect (`tactiledata.effects.base.Effect`).
"""


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


CLAUSES = {
    "a name where nothing is missing": "false alarms on nulls",
    "says what was left out": "visible effects named",
    "a wrong name": "wrong names",
    "the fit improves": "gap closed on held-out trajectories, where rightly named",
    "says it where it is concealed": "effects concealed by calibration named",
}
"""What is claimed, and the target that measures it."""


def clause_rows(cases: Sequence[ScoredCase]) -> list[tuple[str, ...]]:
    """A row for each clause of the claim: how often it holds with each generator, and with all of them."""
    groups = {**by_generator(cases), "all": cases}
    targets = [{one["what"]: one for one in score_of(group)["targets"]} for group in groups.values()]
    head = ("", *groups, "target")
    rows = [
        (clause, *(f"{one[what]['right']} of {one[what]['count']}" for one in targets), targets[-1][what]["target"])
        for clause, what in CLAUSES.items()
    ]
    return [head, *rows]


def by_generator(cases: Sequence[ScoredCase]) -> dict[str, list[ScoredCase]]:
    """Cases of each generator, by its name."""
    names = [case.label["configuration"]["generator"] for case in cases]
    return {name: [case for case, own in zip(cases, names, strict=True) if own == name] for name in sorted(set(names))}


def draw(path: Path, cases: Sequence[ScoredCase]) -> None:
    """Draw which share of single effects is named, with 95 % intervals, by signal: a line for each generator."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7, 3.6), dpi=110, facecolor="white", layout="constrained")
    FigureCanvasAgg(figure)
    panel = figure.subplots()
    strengths = {name: score_of(own)["strength"] for name, own in by_generator(cases).items()}
    # ranges from the first that has a case
    shown = SIGNALS[SIGNALS.index(min(one["signal"][0] for ranges in strengths.values() for one in ranges)) :]
    for place, (name, ranges) in enumerate(strengths.items()):
        shares = np.array([one["named"]["right"] / one["named"]["count"] for one in ranges])
        reach = np.array([one["named"]["interval"] for one in ranges])
        # beside one another, so that intervals do not hide each other
        x = np.array([shown.index(one["signal"][0]) for one in ranges]) + 0.12 * (place - (len(strengths) - 1) / 2)
        bars = np.abs(np.stack([shares - reach[:, 0], reach[:, 1] - shares]))
        panel.errorbar(x, 100 * shares, 100 * bars, fmt="o-", capsize=3, label=name)
        for at, share, one in zip(x, shares, ranges, strict=True):
            panel.annotate(
                str(one["named"]["count"]), (at, 100 * share), xytext=(4, 4), textcoords="offset points", fontsize=7
            )
    panel.axhline(80, color="0.6", linestyle=":", linewidth=1)
    ends = [signal_words(low, high) for low, high in pairwise(shown)]
    panel.set_xticks(range(len(ends)), ends)
    panel.set(
        xlabel="signal of the hidden effect, over the noise",
        ylabel="named rightly, % of cases",
        ylim=(-4, 104),
        title="Single effects in sealed worlds (simulated recordings)",
    )
    panel.legend(title="generator", fontsize=8, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    panel.grid(alpha=0.3)
    figure.savefig(path, metadata={"Software": None})


def strength_rows(score: Mapping[str, Any]) -> list[tuple[str, ...]]:
    """A row for each range of signals: its ends, and how many single effects are named, and named or in the set."""
    rows = []
    for one in score["strength"]:
        ends = signal_words(*one["signal"])
        rows.append((ends, *(f"{one[key]['right']} of {one[key]['count']}" for key in ("named", "named_or_in_set"))))
    return rows


def outside_row(cases: Sequence[ScoredCase]) -> list[tuple[str, str]]:
    """A row on wrong names outside the catalogue, if there are any: how often the answer tells of what is hidden."""
    wrong = [case for case in cases if case.kind == OUTSIDE and case.is_wrong_name]
    told = sum(TOLD_ALIKE.get(case.hidden) in case.answer["names"] for case in wrong)
    what = "wrong names outside the catalogue whose answer says that what is hidden gets that name"
    return [(what, f"{told} of {len(wrong)}")] if wrong else []


def other_rows(score: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Rows of other numbers: size of the set, error of the probabilities, material, gap."""
    rows = [("effects in the set of named single effects, mean", f"{score['mean_set']}")]
    rows.append(("error of the probabilities (ECE), all cases", f"{score['probabilities']['ece']}"))
    if score["material"]:
        for side, words in (("before", "without"), ("after", "with")):
            listed = ", ".join(f"{value:.1f}" for value in score["material"][side])
            rows.append((f"median error of E, nu, mu {words} what is named, %", listed))
    if score["gap_closed"]:
        rows.append(("gap closed on held-out indenters, median, rightly named", f"{score['gap_closed']['share']:.2f}"))
    return rows


ROOT = Path(__file__).parents[1]
PAGES = (ROOT / "docs" / "proof.md", ROOT / "docs" / "proof-ensembles.md")
HEADER = "the targets over several sealed proofs (simulated recordings)"
COMMAND = re.compile(
    r"(`python benchmarks/proof_pooled\.py (?P<archives>docs/proofs/\S+\.zip(?: docs/proofs/\S+\.zip)*)[ `].*?"
    r"\n```text\n).*?\n```",
    re.DOTALL,
)
"""A command on a page that names archives, and the block below it that holds what it prints."""
CLAUSE_BLOCK = re.compile(r"```text\n +\S[^\n]* target\n---.*?\n```", re.DOTALL)


def written_anew(page: str) -> str:
    """The page with what its commands print today; the clauses of the first, which stand by themselves, as well."""
    printed = {
        found["archives"]: printed_lines([ROOT / archive for archive in found["archives"].split()])
        for found in COMMAND.finditer(page)
    }
    if not printed:
        return page
    lines = next(iter(printed.values())).splitlines()
    start = next(place for place, line in enumerate(lines) if line.startswith(" ") and line.endswith("target"))
    clauses = "\n".join(lines[start : start + 2 + len(CLAUSES)])
    # functions, so that no backslash means anything
    page = CLAUSE_BLOCK.sub(lambda _: f"```text\n{clauses}\n```", page)
    return COMMAND.sub(lambda found: f"{found[1]}{printed[found['archives']]}\n```", page)


def print_all(paths: Sequence[Path], picture: Path | None) -> None:
    """Print the proofs, the targets and what single effects of each signal were answered."""
    cases: list[ScoredCase] = []
    rows = []
    for path in paths:
        with opened_proof(path) as folder:
            request, seal = ProofRequest.of(read_json(folder.proof)["request"]), read_json(folder.seal)
            answered = scored_cases(folder)
        taken = pooled(answered, request.only)
        cases += taken
        rows.append((path.stem, seal["tool"]["commit"][:8], seal["root"][:8], f"{len(taken)} of {len(answered)}"))
    header(HEADER, ("numpy",))
    table(("proof", "sealed at", "root", "cases taken"), rows)
    head, *clauses = clause_rows(cases)
    table(head, clauses)
    score = score_of(cases)
    table(("what", "target", "found", "95 % interval", "over configurations", ""), target_rows(score))
    table(("signal of single effects", "named", "named or in the set"), strength_rows(score))
    table(("what", "found"), [*other_rows(score), *outside_row(cases)])
    if picture:
        draw(picture, cases)


def printed_lines(paths: Sequence[Path], picture: Path | None = None) -> str:
    """What is printed of proofs, without spaces at the ends of lines."""
    with redirect_stdout(io.StringIO()) as said:
        print_all(paths, picture)
    return "\n".join(line.rstrip() for line in said.getvalue().strip().splitlines())


def main() -> None:
    """Print what is asked for, or write the pages anew."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("proofs", type=Path, nargs="*")
    parser.add_argument("--picture", type=Path, help="a .png to draw")
    parser.add_argument("--write", action="store_true", help="write the pages anew whose commands name archives")
    given = parser.parse_args()
    if given.proofs:
        print(printed_lines(given.proofs, given.picture))
    for page in PAGES if given.write else ():
        page.write_text(written_anew(page.read_text()))


if __name__ == "__main__":
    main()
