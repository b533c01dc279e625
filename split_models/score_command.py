"""`score`: how far apart the pictures of a store's sensors are, and their latent vectors."""

from __future__ import annotations

from pathlib import Path

import typer

from tactiledata.cli.explain import damage_explains
from tactiledata.cli.output import JSON_OPTION, emit, progress, say, table
from tactiledata.cli.working_store import STORE_ARGUMENT, working_store
from tactiledata.errors import UnknownName

MODEL = typer.Option(None, "--model", help="Checkpoint of an image VAE whose latent vectors t-SNE looks at.")
WEIGHTS = typer.Option(None, "--weights", help="torchvision's VGG-19 weights [default: those in PyTorch's cache].")
OUT = typer.Option(Path("scores"), "--out", help="Folder for the picture of t-SNE.")


def register(app: typer.Typer) -> None:
    """Add the verb; nothing heavy is imported until it is used."""
    app.command("score")(score)


def score(
    store: str = STORE_ARGUMENT,
    metric: str = typer.Option(..., "--metric", help="histogram_intersection, gram_style, tsne, … with commas."),
    against: str = typer.Option(
        None, "--against", help="Sensors that all others are scored against, with commas [default: every pair]."
    ),
    model: Path = MODEL,
    weights: Path = WEIGHTS,
    most: int = typer.Option(200, "--frames", min=1, help="Frames of each sensor at most, spread evenly."),
    out: Path = OUT,
    as_json: bool = JSON_OPTION,
) -> None:
    """Score the pictures of sensors against each other. Transferred ones apart, with intervals over trajectories.

    Example: tactiledata score both.zarr --metric histogram_intersection,gram_style,tsne --against ycb-sensorA
    """
    from split_models.latent_vectors import picture_vectors, vectors_by_model
    from tactiledata.scoring.chosen_scores import TSNE, chosen_scores
    from tactiledata.scoring.embedding_picture import draw_embedding, embed_sets
    from tactiledata.scoring.sensor_pairs import score_pairs
    from tactiledata.scoring.sensor_sets import sensor_sets
    from tactiledata.store.reader import Store
    from tactiledata.store.simulated import simulated_recordings, simulated_sensors

    location = working_store(store)
    names = _listed(metric)
    with damage_explains(location):
        opened = Store.open(location)
        simulated = simulated_recordings(opened)
        scores = chosen_scores(names, weights)
        sets = sensor_sets(opened, most)
        named = None if against is None else _listed(against)
        for name in named or ():
            if name not in (known := [one.name for one in sets]):
                raise UnknownName("set of pictures", name, known)
        encode = vectors_by_model(model) if model is not None else picture_vectors
        with progress("scoring", quiet=as_json) as tell:
            found = list(score_pairs(opened, scores, sets, named, encode, tell))
        picture = None
        if TSNE in names:
            picture = draw_embedding(embed_sets(opened, sets, encode), out / "tsne.png", simulated.heading)
    if as_json:
        drawn = str(picture) if picture else None
        facts = {"tsne": drawn, "simulated_recordings": simulated.document()}
        emit({"store": location, "scores": [one.document() for one in found], **facts})
        return
    columns = ("score", "of", "against", "column", "looked at", "mean and 95 % interval")
    kinds = {True: "Synth.", False: "Real"}
    table(
        simulated.heading,
        columns,
        [(o.score.title, o.first, o.second, kinds[o.is_synthetic], o.looked_at, o.interval) for o in found],
    )
    if simulated.label:
        say(f"simulated recordings: those of {', '.join(simulated_sensors(opened))}")
    say("; ".join(dict.fromkeys(f"{one.score.title}: {one.score.better} is closer" for one in found)))
    if picture is not None:
        say(f"wrote {picture}")


def _listed(words: str) -> list[str]:
    return [word.strip() for word in words.split(",") if word.strip()]
