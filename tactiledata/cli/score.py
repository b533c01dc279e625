"""`score`: how far apart the pictures of a store's sensors are."""

from __future__ import annotations

import typer

from tactiledata.cli.explain import damage_explains
from tactiledata.cli.output import JSON_OPTION, emit, progress, say, table
from tactiledata.cli.working_store import STORE_ARGUMENT, working_store
from tactiledata.errors import UnknownName


def register(app: typer.Typer) -> None:
    """Add this module's command."""
    app.command("score")(score)


def score(
    store: str = STORE_ARGUMENT,
    metric: str = typer.Option(..., "--metric", help="Metrics or scores of sets of pictures, with commas."),
    against: str = typer.Option(
        None, "--against", help="Sensors that all others are scored against, with commas [default: every pair]."
    ),
    most: int = typer.Option(200, "--frames", min=1, help="Frames of each sensor at most, spread evenly."),
    as_json: bool = JSON_OPTION,
) -> None:
    """Score the pictures of sensors against each other. Transferred ones apart, with intervals over trajectories.

    Example: tactiledata score both.zarr --metric histogram_intersection --against ycb-sensorA
    """
    from tactiledata.scoring.sensor_pairs import score_pairs, set_scores
    from tactiledata.scoring.sensor_sets import sensor_sets
    from tactiledata.store.reader import Store

    location = working_store(store)
    with damage_explains(location):
        opened = Store.open(location)
        scores = set_scores(_listed(metric))
        sets = sensor_sets(opened, most)
        named = None if against is None else _listed(against)
        for name in named or ():
            if name not in (known := [one.name for one in sets]):
                raise UnknownName("set of pictures", name, known)
        with progress("scoring", quiet=as_json) as tell:
            found = list(score_pairs(opened, scores, sets, named, tell))
    if as_json:
        emit({"store": location, "scores": [one.document() for one in found]})
        return
    rows = [
        (one.score.title, one.first, one.second, "Synth." if one.is_synthetic else "Real", one.region, one.interval)
        for one in found
    ]
    table("", ("score", "of", "against", "column", "region", "mean and 95 % interval"), rows)
    say("; ".join(dict.fromkeys(f"{one.score.title}: {one.score.better} is closer" for one in found)))


def _listed(words: str) -> list[str]:
    return [word.strip() for word in words.split(",") if word.strip()]
