"""Latent vectors and strips of pictures for the table of domain alignment: scores of the vectors, and t-SNE."""

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
from tactiledata.report.plots import difference_picture
from tactiledata.scoring.embedding_picture import draw_embedding, embed_vectors
from tactiledata.store.layout.places import folder_name

if TYPE_CHECKING:
    from split_models.networks.image_vae import ImageVae
    from split_models.tables.domain_alignment import Alignment

Rows = list[dict[str, Any]]
Vectors = dict[str, dict[str, NDArray[np.floating]]]
AS_RECORDED = "as_recorded"
"""Name of the row of recorded pictures, which are not transferred."""
SHOWN_SOURCES = 2
"""Number of sources, the first ones, whose latent vectors are compared, as in the paper."""
STRIP = 3
"""Touches in a strip."""


def latent_rows(table: Alignment) -> Rows:
    """Rows with silhouette, kNN mixing and MMD² between latent vectors of the first sources and of the targets.

    A source's Z_deform is compared with a target's; so is its Z_image as recorded, and after the latent arithmetic. A
    picture of t-SNE is written as well.
    """
    most, rounds = table.recipe_run.recipe.rows["frames"], table.recipe_run.recipe.rows["rounds"]
    vectors, touches = _vectors(table, most)
    path = draw_embedding(embed_vectors(vectors), table.recipe_run.tables / "tsne.png")
    table.recipe_run.tell(1, 1, f"t-SNE: {path.name}")
    rows: Rows = []
    for letter, target in table.targets.items():
        for source in table.sources[:SHOWN_SOURCES]:
            # the recorded source, then the source after its background was exchanged for the target's
            image_kinds = [kind for kind in vectors[target] if kind.startswith("Z_image")]
            pairs = [(kind, source) for kind in vectors[target]]
            for kind, first in pairs + [(kind, _moved_name(source, letter)) for kind in image_kinds]:
                ours, theirs = vectors[first][kind], vectors[target][kind]
                values = {name: score.compute(ours, theirs) for name, score in EMBEDDING.scores.items()}
                scores = summarised(values, touches[first], rounds, EMBEDDING.scores)
                words = f"{kind}, {first} against {letter}"
                rows.append({"part": "latent vectors", "method": words, "target": letter, "scores": scores})
    return rows


def _vectors(table: Alignment, most: int) -> tuple[Vectors, dict[str, NDArray[np.object_]]]:
    """Latent vectors by set and kind, of the recipe's image VAE and of variants among the rows; touches by set."""
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
            latents = {f"Z_deform{words}": subtract(image, bases[name]), f"Z_image{words}": image}
            vectors.setdefault(name, {}).update({kind: values.numpy() for kind, values in latents.items()})
            touches[name] = unit.touches[numbers[name]]
        for letter, target in table.targets.items():
            for source in table.sources[:SHOWN_SOURCES]:
                moved = vectors[source][f"Z_deform{words}"] + bases[target].numpy()
                vectors.setdefault(_moved_name(source, letter), {})[f"Z_image{words}"] = moved
                touches[_moved_name(source, letter)] = touches[source]
    return vectors, touches


def _models(table: Alignment) -> dict[str, ImageVae]:
    """Image VAEs by the words that mark their variant; empty words for the recipe's own."""
    variants = dict.fromkeys(row.rpartition(":")[0] for row in table.methods)
    return {f" ({name})" if name else "": table.recipe_run.variant(name).image_vae for name in {"": None, **variants}}


def _moved_name(source: str, letter: str) -> str:
    """Name of the set of a source's pictures after their transfer to a target."""
    return f"{source} to {letter}"


def write_strips(table: Alignment) -> None:
    """Write ``strip-SOURCE-TARGET.png``: touches, their transfers by each method, and the true pictures if recorded.

    One strip shows the first source for every target. Two more show the first two targets for each other: the networks
    learned neither from these sensors nor, where the paired touches are of held-out indenters, from the shapes.
    """
    ways = [(table.sources[0], target) for target in table.targets.values()]
    unseen = list(table.targets.values())[:2]
    if len(unseen) == 2:
        ways += [(unseen[0], unseen[1]), (unseen[1], unseen[0])]
    for source, target in ways:
        strip = _strip(table, source, target)
        _, encoded = cv2.imencode(".png", strip[..., ::-1])
        write_atomic(
            table.recipe_run.tables / f"strip-{folder_name(source)}-{folder_name(target)}.png", encoded.tobytes()
        )


def _strip(table: Alignment, source: str, target: str) -> NDArray[np.uint8]:
    """Picture of a strip: each row a recorded touch and its transfers.

    Where touches are paired, the target's own picture follows, and where each transfer differs from it, doubled about
    grey.
    """
    source_unit, target_unit = table.units[source], table.units[target]
    ours, theirs = paired_frames(source_unit, target_unit, len(source_unit))
    if not len(ours):
        ours = np.arange(len(source_unit))
    chosen = _middles(source_unit, ours)
    touches = source_unit.pictures(ours[chosen])
    moved = {name: table.moved(name, touches, source, target) for name in table.methods}
    truth = target_unit.pictures(theirs[chosen]) if len(theirs) else None
    recorded = recorded_title(table.recipe_run.store)
    lines = []
    for row, touch in enumerate(touches):
        cells = [
            (f"{source}", touch),
            *((name.replace("_", " "), transferred[row]) for name, transferred in moved.items()),
        ]
        if truth is not None:
            left = [
                (f"{name.replace('_', ' ')}, where it differs x2", difference_picture(transferred[row], truth[row]))
                for name, transferred in moved.items()
                if transferred[row].shape == truth[row].shape
            ]
            cells += [(f"{target}, {recorded}", truth[row]), *left]
        lines.append(cells)
    return sheet(lines)


def _middles(unit: UnitFrames, numbers: NDArray[np.int64]) -> NDArray[np.int64]:
    """Places in ``numbers`` of the middle frame of a few touches, which are spread evenly over all touches."""
    names = unit.touches[numbers]
    known = list(dict.fromkeys(names))
    shown = [known[place] for place in spread_evenly(len(known), STRIP)]
    return np.array([int(np.median(np.flatnonzero(names == name))) for name in shown], np.int64)
