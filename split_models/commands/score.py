"""The command `score`: distances between the pictures of a store's sensors, and between their latent vectors."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from split_models.commands.device_option import DEVICE, require_device
from tactiledata.cli.explain import damage_explains
from tactiledata.cli.given_values import listed_names, need_writable_folder, refuse_given
from tactiledata.cli.output import JSON_OPTION, emit, progress, say, table
from tactiledata.cli.working_store import STORE_ARGUMENT, working_store
from tactiledata.contract.extras import need_packages
from tactiledata.errors import UnknownName, UsageError

if TYPE_CHECKING:
    from tactiledata.metrics.base import Score
    from tactiledata.scoring.sensor_pairs import PairScore
    from tactiledata.scoring.sensor_sets import SensorSet
    from tactiledata.store.read.reader import Store
    from tactiledata.store.read.targets import Target

MODEL = typer.Option(None, "--model", help="Checkpoint of an image VAE, for t-SNE of its latent vectors.")
WEIGHTS = typer.Option(None, "--weights", help="torchvision's VGG-19 weights [default: those in PyTorch's cache].")
PICTURE = "tsne.png"
LEAST_VECTORS = 2
"""Fewest frames of a sensor whose vectors can be compared."""
OUT = typer.Option(Path("scores"), "--out", help="Folder for the picture of t-SNE.")


def register(app: typer.Typer) -> None:
    """Add the command `score` to the application."""
    app.command("score")(score)


def score(
    context: typer.Context,
    store: str = STORE_ARGUMENT,
    metric: str = typer.Option(
        ...,
        "--metric",
        help="Comma-separated scores: histogram_intersection, histogram_correlation, gram_style, gram_style_random, "
        "tsne, silhouette, knn_mixing, mmd, kept_touch.",
    ),
    against: str = typer.Option(
        None,
        "--against",
        help="Comma-separated sensors that all others are scored against: sets of the store, or names that "
        "`tactiledata sensors` lists [default: every pair].",
    ),
    model: Path = MODEL,
    weights: Path = WEIGHTS,
    most: int = typer.Option(200, "--frames", min=1, help="Largest number of frames of each sensor, spread evenly."),
    out: Path = OUT,
    device: str = DEVICE,
    as_json: bool = JSON_OPTION,
) -> None:
    """Score pictures of sensors against each other, with intervals.

    Recorded and synthetic pictures are separate sets. Results state how much of the touch synthetic pictures keep.
    A sensor of --against may be known by a picture without contact only; it is then compared outside the contact.

    Example: tactiledata score both.zarr --metric histogram_intersection,gram_style,tsne --against ycb-sensorA
    """
    need_packages("a score", "torch")
    from split_models.transfer.latent_vectors import picture_vectors, vectors_by_model
    from tactiledata.scoring.background_targets import score_backgrounds, sentences, unlocated
    from tactiledata.scoring.chosen_scores import KEPT, STYLE, TSNE, chosen_scores, needs_vectors
    from tactiledata.scoring.embedding_picture import draw_embedding, embed_sets
    from tactiledata.scoring.kept_touches import kept_scores
    from tactiledata.scoring.sensor_pairs import score_pairs
    from tactiledata.scoring.sensor_sets import require_sets, sensor_sets, size_sentences
    from tactiledata.store.read.reader import Store
    from tactiledata.store.read.simulated import simulated_recordings, simulated_sensors

    # choose sets of pictures, scores and targets
    location = working_store(store)
    require_device(device)
    names = listed_names(metric, "--metric")
    if TSNE in names:
        need_writable_folder(out, PICTURE)
    else:
        refuse_given(context, ["out"], "without tsne in --metric", "with tsne")
    if STYLE not in names:
        refuse_given(context, ["weights"], f"without {STYLE} in --metric", f"with {STYLE}")
    with damage_explains(location):
        opened = Store.open(location)
        simulated = simulated_recordings(opened)
        scores = chosen_scores(names, weights, device)
        if needs_vectors(names, scores):
            if most < LEAST_VECTORS:
                raise UsageError(f"--frames {most}", f"{LEAST_VECTORS} or more, for scores of vectors")
        else:
            refuse_given(context, ["model"], "without a score of vectors in --metric", "with one, such as tsne")
        sets = sensor_sets(opened, most, least=1)
        named, targets = (None, []) if against is None else _against(listed_names(against, "--against"), sets, opened)
        if not targets and scores:
            require_sets(opened, sets, 2)
        encode = vectors_by_model(model, device) if model is not None else picture_vectors
        # score, and draw t-SNE where it was requested
        with progress("scoring", quiet=as_json) as tell:
            pair_scores = list(score_pairs(opened, scores, sets, named, encode, tell)) if scores else []
        if targets and scores:
            pair_scores += score_backgrounds(opened, scores, sets, targets)
        kept, unknown = kept_scores(opened, sets)
        if KEPT in names and not kept and not unknown:
            unknown = [
                "No set was made of touches of this store, so that none keeps any. `tactiledata transfer` makes one, "
                "and `tactiledata merge` puts it beside its parents."
            ]
        notes = [*unknown, *size_sentences(sets), *sentences(targets, unlocated(opened, sets) if targets else [])]
        kinds = {pictures.name: pictures.kind for pictures in sets}
        heading = simulated.heading
        drawn = None
        if TSNE in names:
            drawn = draw_embedding(embed_sets(opened, sets, encode), out / PICTURE, kinds, heading)
    if as_json:
        picture = str(drawn) if drawn else None
        facts = {"tsne": picture, "notes": notes, "simulated_recordings": simulated.document()}
        emit({"store": location, "scores": documents(pair_scores), "kept": documents(kept), **facts})
        return
    for part in (pair_scores, kept):
        _print_scores(part, heading)
    for note in notes:
        say(note)
    if simulated.label:
        say(f"simulated recordings: those of {', '.join(simulated_sensors(opened))}")
    if drawn is not None:
        say(f"wrote {drawn}")


def _against(names: Sequence[str], sets: Sequence[SensorSet], store: Store) -> tuple[list[str], list[Target]]:
    """Names that are sets of the store, and targets of which only a picture without contact is known.

    Raises
    ------
    UnknownName
        A name is neither.
    """
    from tactiledata.store.read.targets import find_target

    known = [pictures.name for pictures in sets]
    touched, targets = [], []
    for name in names:
        if name in known:
            touched.append(name)
            continue
        try:
            target = find_target(name, store)
        except UnknownName as error:
            raise UnknownName("set of pictures or sensor", name, [*known, *error.facts["known"]]) from error
        if target.name in known:
            touched.append(target.name)
        else:
            targets.append(target)
    return touched, targets


def documents(scores: Sequence[PairScore]) -> list[dict[str, Any]]:
    """Scores as values for JSON."""
    return [score.document() for score in scores]


def _print_scores(scores: Sequence[PairScore], heading: str) -> None:
    """Print a table under a heading, then directions and missing intervals; nothing where there are no scores."""
    from tactiledata.metrics.bootstrap import LEAST_GROUPS

    if not scores:
        return
    columns = ("score", "of", "which is", "against", "which is", "looked at", "mean and 95 % interval")
    rows = [
        (pair.score.title, pair.first, pair.first_kind, pair.second, pair.second_kind, pair.looked_at, pair.interval)
        for pair in scores
    ]
    table(heading, columns, rows)
    say("; ".join(dict.fromkeys(f"{pair.score.title}: {_direction(pair.score)} is closer" for pair in scores)))
    few = dict.fromkeys(pair.first for pair in scores if pair.interval.trajectories < LEAST_GROUPS)
    if few:
        say(f"no interval for {', '.join(few)}: it takes {LEAST_GROUPS} trajectories")


def _direction(score: Score) -> str:
    """The values of a score that are closer, in words."""
    return f"nearer to {score.best:g}" if score.better == "nearest" else score.better
