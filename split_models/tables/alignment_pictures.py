"""What goes with the table of domain alignment: latent vectors on a plane and their scores, and strips to look at."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import cv2
import numpy as np
from numpy.typing import NDArray

from split_models.networks.latent import encode_pictures, subtract
from split_models.tables.evaluate import summarised
from split_models.tables.recorded_title import recorded_title
from split_models.tables.unit_frames import UnitFrames, paired_frames, spread_evenly
from split_models.transfer.transfer_picture import sheet
from tactiledata.contract.atomic import write_atomic
from tactiledata.metrics.embedding import EMBEDDING
from tactiledata.scoring.embedding_picture import draw_embedding, embed_vectors

if TYPE_CHECKING:
    from split_models.networks.image_vae import ImageVae
    from split_models.tables.domain_alignment import Alignment

Rows = list[dict[str, Any]]
Vectors = dict[str, dict[str, NDArray[np.floating]]]
AS_RECORDED = "as_recorded"
"""The row of sources that are not transferred."""
SHOWN_SOURCES = 2
"""Sources whose latent vectors are looked at, as in the paper: the first ones."""
STRIP = 3
"""Touches of a strip."""


def latent_rows(table: Alignment) -> Rows:
    """Silhouette, kNN mixing and MMD² of latent vectors of the first sources and the targets; t-SNE is drawn beside.

    Z_deform of a source against a target's; Z_image as recorded, and after the arithmetic, against a target's.
    """
    most, rounds = table.recipe_run.recipe.rows["frames"], table.recipe_run.recipe.rows["rounds"]
    vectors, touches = _vectors(table, most)
    drawn = draw_embedding(embed_vectors(vectors), table.recipe_run.tables / "tsne.png")
    table.recipe_run.tell(1, 1, f"t-SNE: {drawn.name}")
    rows: Rows = []
    for letter, target in table.targets.items():
        for source in table.sources[:SHOWN_SOURCES]:
            of_models = [kind for kind in vectors[target] if kind.startswith("Z_image")]
            pairs = [(kind, source) for kind in vectors[target]]
            for kind, first in pairs + [(kind, _arrived(source, letter)) for kind in of_models]:
                ours, theirs = vectors[first][kind], vectors[target][kind]
                values = {name: score.compute(ours, theirs) for name, score in EMBEDDING.scores.items()}
                scores = summarised(values, touches[first], rounds, EMBEDDING.scores)
                words = f"{kind}, {first} against {letter}"
                rows.append({"part": "latent vectors", "method": words, "target": letter, "scores": scores})
    return rows


def _vectors(table: Alignment, most: int) -> tuple[Vectors, dict[str, NDArray[np.object_]]]:
    """Vectors by set and kind, of the recipe's model and of variants among its rows, and their touches."""
    vectors: Vectors = {}
    touches: dict[str, NDArray[np.object_]] = {}
    shown = [*table.sources[:SHOWN_SOURCES], *table.targets.values()]
    numbers = {name: spread_evenly(len(table.units[name]), most) for name in shown}
    for words, vae in _models(table).items():
        bases = {}
        for name in shown:
            unit = table.units[name]
            bases[name] = encode_pictures(vae, unit.background[None])
            image = encode_pictures(vae, unit.pictures(numbers[name]))
            found = {f"Z_deform{words}": subtract(image, bases[name]), f"Z_image{words}": image}
            vectors.setdefault(name, {}).update({kind: some.numpy() for kind, some in found.items()})
            touches[name] = unit.touches[numbers[name]]
        for letter, target in table.targets.items():
            for source in table.sources[:SHOWN_SOURCES]:
                arrived = vectors[source][f"Z_deform{words}"] + bases[target].numpy()
                vectors.setdefault(_arrived(source, letter), {})[f"Z_image{words}"] = arrived
                touches[_arrived(source, letter)] = touches[source]
    return vectors, touches


def _models(table: Alignment) -> dict[str, ImageVae]:
    """Image VAEs by what is said of them."""
    variants = dict.fromkeys(row.rpartition(":")[0] for row in table.methods)
    return {f" ({name})" if name else "": table.recipe_run.variant(name).image_vae for name in {"": None, **variants}}


def _arrived(source: str, letter: str) -> str:
    return f"{source} to {letter}"


def write_strips(table: Alignment) -> None:
    """``strip-SOURCE-TARGET.png``: touches, what each method makes of them, and where it was recorded the truth.

    Of the first source to every target, and between the first two targets both ways: there neither the sensors nor,
    where the paired touches are of held-out indenters, the geometry was learned from.
    """
    ways = [(table.sources[0], target) for target in table.targets.values()]
    unseen = list(table.targets.values())[:2]
    if len(unseen) == 2:
        ways += [(unseen[0], unseen[1]), (unseen[1], unseen[0])]
    for source, target in ways:
        drawn = _strip(table, source, target)
        _, encoded = cv2.imencode(".png", drawn[..., ::-1])
        write_atomic(table.recipe_run.tables / f"strip-{source}-{target}.png", encoded.tobytes())


def _strip(table: Alignment, source: str, target: str) -> NDArray[np.uint8]:
    one, other = table.units[source], table.units[target]
    ours, theirs = paired_frames(one, other, len(one))
    if not len(ours):
        ours = np.arange(len(one))
    chosen = _middles(one, ours)
    touches = one.pictures(ours[chosen])
    moved = {name: table.moved(name, touches, source, target) for name in table.methods}
    truth = other.pictures(theirs[chosen]) if len(theirs) else None
    recorded = recorded_title(table.recipe_run.store)
    lines = []
    for row, touch in enumerate(touches):
        cells = [(f"{source}", touch), *((name.replace("_", " "), found[row]) for name, found in moved.items())]
        lines.append(cells if truth is None else [*cells, (f"{target}, {recorded}", truth[row])])
    return sheet(lines)


def _middles(unit: UnitFrames, numbers: NDArray[np.int64]) -> NDArray[np.int64]:
    """Places in ``numbers`` of the middle frame of a few touches, spread over all of them."""
    names = unit.touches[numbers]
    known = list(dict.fromkeys(names))
    shown = [known[place] for place in spread_evenly(len(known), STRIP)]
    return np.array([int(np.median(np.flatnonzero(names == name))) for name in shown], np.int64)
