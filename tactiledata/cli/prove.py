"""`prove`: sealed cases of known truth, diagnosed, scored and checked."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from tactiledata.cli.given_values import (
    is_given,
    listed_names,
    need_folder,
    need_seed,
    need_writable_folder,
    refuse_given,
)
from tactiledata.cli.output import JSON_OPTION, emit, progress, say, table
from tactiledata.cli.task_options import SCHEDULER, WORKERS
from tactiledata.contract.extras import GEL, PAGE, need_packages
from tactiledata.contract.wording import counted
from tactiledata.errors import UnknownName, UsageError

if TYPE_CHECKING:
    from tactiledata.prove.request import ProofRequest
    from tactiledata.prove.seal.compare import AnswerComparison
    from tactiledata.prove.seal.folder import ProofFolder

SEEDS = 2**31
"""Number of seeds, from 0."""


def register(app: typer.Typer) -> None:
    """Add the command `prove` to the application."""
    app.command("prove")(prove)


def prove(
    context: typer.Context,
    out: Path = typer.Option(None, "--out", help="Folder of the proof; a proof that it holds is gone on with."),
    verify: Path = typer.Option(
        None,
        "--verify",
        help="Check the proof in this folder, or in a .zip that --publish made, without any simulation; exit 1 where it"
        " does not fit.",
    ),
    root: str = typer.Option(None, "--root", help="With --verify: the root that was published before the answers."),
    against: Path = typer.Option(
        None,
        "--against",
        help="With --verify: a copy of the proof that another machine answered; answers are compared.",
    ),
    publish: Path = typer.Option(
        None, "--publish", help="With --verify: write all but the readings into this .zip, for others to check."
    ),
    quick: bool = typer.Option(False, "--quick", help="20 cases of a small plan, in some minutes."),
    generators: str = typer.Option("layer,analytic", "--generators", help="Of layer, analytic, element."),
    plans: str = typer.Option("wedge-2", "--plans", help="Plans of touches: wedge-N, wedge-NxTOUCHES, mounts-N."),
    mismatch: str = typer.Option("1", "--mismatch", help="Sizes of the solvers' own errors: 0,1,2."),
    noise: str = typer.Option("1", "--noise", help="Factors on the noise of the force sensor: 0.4,1."),
    nulls: int = typer.Option(0, "--nulls", min=0, help="Worlds without hidden effects, in each configuration."),
    visible: int = typer.Option(0, "--visible", min=0, help="Worlds with one effect that can be seen."),
    concealed: int = typer.Option(
        0, "--concealed", min=0, help="Worlds with a visible effect that a calibration conceals."
    ),
    pairs: int = typer.Option(0, "--pairs", min=0, help="Worlds with two visible effects."),
    outside: int = typer.Option(0, "--outside", min=0, help="Worlds with an effect outside the catalogue."),
    ambiguous: int = typer.Option(0, "--ambiguous", min=0, help="Worlds with an effect that others can imitate."),
    drawn: int = typer.Option(0, "--drawn", min=0, help="Worlds with one effect of any strength, visible or not."),
    effects: str = typer.Option(None, "--effects", help="Hide only these of the rig's effects: lag,relaxation."),
    seed: int = typer.Option(0, "--seed", help="Random seed of all draws."),
    try_pairs: bool = typer.Option(True, "--try-pairs/--no-try-pairs", help="Whether a diagnosis tries pairs."),
    variants: bool = typer.Option(
        True, "--variants/--no-variants", help="Whether effects take part for which other gels have to be played."
    ),
    full: bool = typer.Option(False, "--full", help="Play gels in full on which an answer could rest (long)."),
    seal_only: bool = typer.Option(
        False, "--seal-only", help="Stop before the first answer: publish the root that is printed, then go on."
    ),
    again: str = typer.Option(None, "--again", help="Diagnose these cases once more: their names, with commas."),
    workers: int = WORKERS,
    scheduler: str = SCHEDULER,
    bank: Path = typer.Option(None, "--bank", help="Folder of kept solutions of generators. Default: in the cache."),
    as_json: bool = JSON_OPTION,
) -> None:
    """Prove the diagnosis on simulated recordings of known truth.

    Cases are drawn and sealed before any of them is diagnosed; then answers are scored. A run that was killed goes on
    with the same command. --seal-only stops after the seal, so that its root can be published first. Everything is
    simulated.

    Example: tactiledata prove --quick --out proof --workers 2
    """
    from tactiledata.prove.seal.folder import ProofFolder

    if (out is None) == (verify is None):
        raise UsageError(
            "neither --out nor --verify" if out is None else "--out and --verify", "one of them",
            "--out FOLDER runs a proof, --verify FOLDER checks one.",
        )  # fmt: skip
    if verify is not None:
        others = [
            parameter.name
            for parameter in context.command.params
            if parameter.name not in ("verify", "root", "against", "publish", "as_json")
        ]
        refuse_given(context, others, "with --verify", "with --out")
        _verify(verify, root, against, publish, as_json)
        return
    refuse_given(context, ["root", "against", "publish"], "with --out", "with --verify")
    if seal_only and again is not None:
        raise UsageError(
            "--again with --seal-only", "one of them", "--seal-only gives no answer; --again gives answers once more."
        )
    need_seed(seed, SEEDS)
    counts = {
        "nulls": nulls, "visible": visible, "concealed": concealed, "pairs": pairs, "outside": outside,
        "ambiguous": ambiguous, "drawn": drawn,
    }  # fmt: skip
    need_writable_folder(out)
    if bank is not None:
        need_writable_folder(bank, option="--bank")
    need_packages("a proof", "sklearn", *GEL, *PAGE)
    folder = ProofFolder(out.absolute())
    request = _request(
        context,
        folder,
        quick,
        {
            "generators": _names(generators, "--generators"),
            "plans": _names(plans, "--plans"),
            "mismatches": _numbers(mismatch, "--mismatch"),
            "noises": _numbers(noise, "--noise"),
            "counts": {kind: count for kind, count in counts.items() if count},
            "seed": seed,
            "only": () if effects is None else _names(effects, "--effects"),
            "with_variants": variants,
            "pairs": try_pairs,
            "in_full": full,
        },
    )
    cases = () if again is None else _names(again, "--again")
    _run(folder, request, _bank(bank), workers, scheduler, cases, seal_only, as_json)


REQUEST = {
    "generators": "generators", "plans": "plans", "mismatch": "mismatches", "noise": "noises", "effects": "only",
    "seed": "seed", "try_pairs": "pairs", "variants": "with_variants", "full": "in_full",
}  # fmt: skip
"""Options that make a request, with the fields that they set."""
COUNTS = ("nulls", "visible", "concealed", "pairs", "outside", "ambiguous", "drawn")
"""Options that set a count."""


def _request(context: typer.Context, folder: ProofFolder, quick: bool, values: dict[str, Any]) -> ProofRequest:
    """Return what is asked: by the options, or by the folder where a proof is gone on with."""
    from tactiledata.prove.request import QUICK, ProofRequest
    from tactiledata.prove.seal.folder import read_json

    given = [name for name in (*REQUEST, *COUNTS) if is_given(context, name)]
    if folder.proof.exists() and not given and not quick:
        return ProofRequest.of(read_json(folder.proof)["request"])
    if not quick:
        return ProofRequest(**values).checked()
    # options beside --quick change what it asks
    changed = {REQUEST[name]: values[REQUEST[name]] for name in given if name in REQUEST}
    if any(name in COUNTS for name in given):
        typed = {name: values["counts"].get(name, 0) for name in given if name in COUNTS}
        return replace(QUICK, **changed).with_counts({**QUICK.counts, **typed}).checked()
    return replace(QUICK, **changed).checked()


def _names(text: str, option: str) -> tuple[str, ...]:
    """Return the names in an option."""
    return tuple(listed_names(text, option))


def _numbers(text: str, option: str) -> tuple[float, ...]:
    """Return the numbers in an option."""
    try:
        return tuple(float(word) for word in text.split(","))
    except ValueError as error:
        raise UsageError(f"{option} {text}", "numbers with commas", f"For example {option} 0,1.") from error


def _bank(bank: Path | None) -> Path:
    """Return the folder of kept solutions; the cache's where none is named."""
    from tactiledata.gel.elasticity.compliance import cache_folder

    return cache_folder() / "generators" if bank is None else bank


def _run(
    folder: ProofFolder,
    request: ProofRequest,
    bank: Path,
    workers: int,
    scheduler: str | None,
    again: tuple[str, ...],
    seal_only: bool,
    as_json: bool,
) -> None:
    """Run a proof, or the rest of it, and print its score; with ``seal_only``, print the root and stop."""
    from tactiledata.compute import make_scheduler
    from tactiledata.prove.page import write_page
    from tactiledata.prove.run import ProofRun

    if again:
        _need_cases(folder, again)
    with progress("proving", quiet=as_json) as report_progress:
        tell = (lambda sentence: None) if as_json else say

        def report(done: int, total: int, what: str = "") -> None:
            """Report a step; one that has no name of its own ends in no colon."""
            report_progress(done, total, what.removesuffix(": "))

        run = ProofRun(folder, request, bank.absolute(), make_scheduler(workers, scheduler), report, tell)
        if seal_only:
            seal = run.run_until_sealed()
        else:
            score = run.run(again)
    if seal_only:
        if as_json:
            emit({"root": seal["root"], "cases": len(seal["cases"])})
            return
        say(f"written: {folder.seal}. Root: {seal['root']}")
        say(f"next: publish the root, then {shlex.join(['tactiledata', 'prove', '--out', str(folder.path)])}")
        return
    write_page(folder)
    if as_json:
        emit(score)
        return
    print_score(score)
    say(f"written: {folder.score}, {folder.page}")


def _verify(path: Path, root: str | None, other: Path | None, archive: Path | None, as_json: bool) -> None:
    """Check a proof and print what was found; exit with 1 where something does not fit."""
    from tactiledata.prove.seal.compare import compare
    from tactiledata.prove.seal.published import SUFFIX, opened_proof, publish
    from tactiledata.prove.seal.verify import verify

    for option, place in (("--verify", path), ("--against", other)):
        if place is not None and not (place.suffix.lower() == SUFFIX and place.is_file()):
            need_folder(place, option, f"a folder that `tactiledata prove --out` made, or a {SUFFIX} of --publish")
    if archive is not None:
        if archive.suffix.lower() != SUFFIX:
            raise UsageError(f"--publish {archive}", f"a file name that ends in {SUFFIX}", f"Add {SUFFIX}.")
        need_writable_folder(archive.parent, archive.name, option="--publish")
    with opened_proof(path) as folder:
        found = verify(folder, root, look_for_leaks=True)
        compared = None
        if other is not None:
            with opened_proof(other) as copy:
                compared = compare(folder, copy)
        if archive is not None and not found.faults:
            publish(folder, archive)
    if as_json:
        emit(found.document if compared is None else {**found.document, "compared": compared.document})
    else:
        for fault in found.faults:
            say(f"does not fit: {fault}")
        for note in found.notes:
            say(f"note: {note}")
        whole = "All hashes and the score fit" if not found.faults else f"{counted(len(found.faults), 'fault')}"
        say(f"{whole}: {counted(found.cases, 'case')}, {counted(found.answers, 'answer')}. Root: {found.root}")
        if found.score is not None and not found.faults:
            print_score(found.score)
        if compared is not None:
            print_comparison(compared)
        if archive is not None and not found.faults:
            say(f"written: {archive} ({archive.stat().st_size} bytes)")
    if found.faults:
        raise typer.Exit(1)


def print_comparison(compared: AnswerComparison) -> None:
    """Print how far two sets of answers agree, as a table and a sentence for each difference."""
    from tactiledata.prove.score.shares import interval_words
    from tactiledata.prove.seal.compare import COMPARED

    rows = []
    for field, one in compared.document["agreed"].items():
        rows.append([COMPARED[field], f"{one['count']} of {compared.cases}", interval_words(one["interval"])])
    table("Answers of two machines", ["what", "the same in", "95 % interval"], rows)
    for sentence in compared.differences:
        say(f"differs: {sentence}")


def print_score(score: Any) -> None:
    """Print the score of a proof as tables."""
    from tactiledata.prove.score.score import met_words
    from tactiledata.prove.score.shares import interval_words

    kinds = sorted({name for row in score["by_configuration"].values() for name in row})
    rows = [[where, *(row.get(name, 0) for name in kinds)] for where, row in score["by_configuration"].items()]
    table("Outcomes (simulated recordings)", ["configuration: kind", *kinds], rows)
    rows = [
        [
            one["what"], one["target"], f"{one['right']} of {one['count']}",
            interval_words(one["interval"]),
            met_words(one),
        ]
        for one in score["targets"]
        if one["count"]
    ]  # fmt: skip
    table("Targets", ["what", "target", "found", "95 % interval", ""], rows)
    for sentence in score["misses"]:
        say(f"miss: {sentence}")


def _need_cases(folder: ProofFolder, names: Sequence[str]) -> None:
    """Refuse names of which the proof has no case, before anything is played."""
    from tactiledata.prove.seal.sealing import read_seal

    if not folder.seal.exists():
        raise UsageError(
            f"--again, and {folder.path} holds no sealed cases",
            "a proof whose cases were drawn",
            "Run the same command without --again first.",
        )
    cases = read_seal(folder)["cases"]
    for name in names:
        if name not in cases:
            raise UnknownName("case", name, cases)
