"""The table of domain alignment: pictures of some units, transferred, against the recorded touches of others.

A row marked Synth. is a method's transfer of a source. Another row is the source as recorded; it has the paper's mark
Real only where all recordings state that they are real (`recorded_row`). Where both units recorded the same touches,
each transferred picture is compared with its true one as well.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from split_models.learning.contact_region import contact_region
from split_models.recipe.recipe_run import RecipeRun
from split_models.tables.alignment_pictures import AS_RECORDED, latent_rows, write_strips
from split_models.tables.evaluate import MASKED, Values, summarised
from split_models.tables.paired_differences import difference_part, differences
from split_models.tables.paired_truth import KEPT_SCORES, PAIRED_SCORES, kept_values, paired_values
from split_models.tables.recorded_title import recorded_row
from split_models.tables.unit_frames import UnitFrames, paired_frames, spread_evenly
from split_models.transfer.methods import LATENT, TransferMethod, title_of, vae_transfer
from split_models.transfer.pixels import PIXEL_TRANSFERS
from tactiledata.arrays import PictureArray
from tactiledata.errors import UnknownName, UsageError
from tactiledata.metrics.base import Score
from tactiledata.metrics.gram_style import style_distances
from tactiledata.scoring.chosen_scores import STYLE, chosen_scores

Rows = list[dict[str, Any]]
REFERENCE = "background_swap"
"""Method that the others are compared with, frame by frame, unless a recipe names another."""
SET_SCORES = ("histogram_intersection", "histogram_correlation", STYLE)
"""Scores between two sets of pictures."""


@dataclass(frozen=True)
class Alignment:
    """The units that are compared, the transfer methods and the scores.

    Parameters
    ----------
    recipe_run : RecipeRun
    methods : dict
        Transfer methods by name.
    sources : list of str
        Sensors whose pictures are transferred.
    targets : dict
        Sensor of each target by its letter in the table.
    scores : dict
        Scores between two sets of pictures by name; one of them is a style distance.
    weights : Path, optional
        File with the weights of VGG-19.
    """

    recipe_run: RecipeRun
    methods: Mapping[str, TransferMethod]
    sources: list[str]
    targets: dict[str, str]
    scores: dict[str, Score]
    weights: Path | None

    @cached_property
    def units(self) -> dict[str, UnitFrames]:
        """Frames of every source and target, by sensor, in the parts that the recipe names."""
        parts = [self.recipe_run.frames(part) for part in self.recipe_run.recipe.rows["parts"]]
        return {name: UnitFrames(parts, name) for name in [*self.sources, *self.targets.values()]}

    @property
    def style(self) -> Score:
        """The style distance among the scores."""
        return next(score for name, score in self.scores.items() if name.startswith(STYLE))

    def moved(self, name: str, pictures: PictureArray, source: str, target: str) -> PictureArray:
        """Pictures of a source, transferred to a target by a method; unchanged for `AS_RECORDED`.

        Parameters
        ----------
        name : str
            Name of the method, or `AS_RECORDED`.
        pictures : (n, h, w, 3) uint8
            Pictures of the source.
        source, target : str
            Sensors.
        """
        if name == AS_RECORDED:
            return pictures
        return self.methods[name].transfer(pictures, self.units[source].background, self.units[target].background)

    def kept(self, name: str, pictures: PictureArray, recorded: PictureArray, source: str, target: str) -> Values:
        """Scores (n,) of how much of recorded touches a method keeps; nothing for `AS_RECORDED`, which keeps all.

        Parameters
        ----------
        name : str
            Name of the method, or `AS_RECORDED`.
        pictures, recorded : (n, h, w, 3) uint8
            Transferred pictures, and those of the source.
        source, target : str
            Sensors.
        """
        if name == AS_RECORDED:
            return {}
        return kept_values(pictures, self.units[target].background, recorded, self.units[source].background)

    @cached_property
    def recorded_row(self) -> str:
        """Title of the rows of recorded pictures."""
        return recorded_row(self.recipe_run.store)

    def title_of(self, name: str) -> str:
        """Title of a method's rows, which a recipe may give; of the recorded pictures for `AS_RECORDED`."""
        if name == AS_RECORDED:
            return self.recorded_row
        variant, _, method = name.rpartition(":")
        given = self.recipe_run.recipe.rows["titles"].get(name)
        return f"{given or title_of(method) + (f', {variant}' if variant else '')} (Synth.)"

    def titled(self, letter: str) -> str:
        """Title of a target in headings; it says whether the model learned from the target."""
        sensor = self.targets[letter]
        known = sensor in self.recipe_run.frames("train").sensor_names
        return f"{letter}: {sensor}" + (", which the model learned from" if known else "")


def prepare_alignment(recipe_run: RecipeRun) -> Alignment:
    """The comparison that a recipe describes, with a trained image VAE.

    Raises
    ------
    UsageError
        The recipe has no sources or no targets, or one sensor is both.
    UnknownName
        A method does not exist.
    MissingFile
        The file of weights that the recipe names does not exist.
    """
    rows = recipe_run.recipe.rows
    sources, targets = list(rows["sources"] or ()), dict(rows["targets"] or {})
    if not sources or not targets:
        raise UsageError(
            f"the recipe {recipe_run.recipe.name} names {'no targets' if sources else 'no sources'}",
            "`rows: {sources: [NAME, ...], targets: {A: NAME, ...}}`",
            "`tactiledata sensors` lists the units of a store.",
        )
    if both := sorted(set(sources) & set(targets.values())):
        raise UsageError(
            f"{', '.join(both)} as source and as target", "other units on each side", "Correct the recipe."
        )
    weights = Path(rows["weights"]) if rows["weights"] else None
    scores = {score.name: score for _, score in chosen_scores(SET_SCORES, weights)}
    methods = {row: _method(recipe_run, row) for row in rows["methods"] or [*LATENT, *PIXEL_TRANSFERS]}
    return Alignment(recipe_run, methods, sources, targets, scores, weights)


def _method(recipe_run: RecipeRun, row: str) -> TransferMethod:
    """The transfer method of a row; ``VARIANT:METHOD`` is a method with the image VAE of a recipe variant."""
    variant, _, name = row.rpartition(":")
    if name in LATENT:
        return vae_transfer(name, recipe_run.variant(variant).image_vae)
    if variant or name not in PIXEL_TRANSFERS:
        raise UnknownName("transfer method" + (" with a model" if variant else ""), name, [*LATENT, *PIXEL_TRANSFERS])
    method: TransferMethod = PIXEL_TRANSFERS[name]
    return method


def alignment_rows(recipe_run: RecipeRun) -> Rows:
    """Rows for each target: each method over all sources and by source, then paired truth, then latent vectors."""
    table = prepare_alignment(recipe_run)
    rows: Rows = []
    for letter in table.targets:
        rows += _set_rows(table, letter)
    for letter in table.targets:
        rows += _paired_rows(table, letter)
    rows += latent_rows(table)
    write_strips(table)
    return rows


def _set_rows(table: Alignment, letter: str) -> Rows:
    """Rows that compare every method's pictures of every source with a target's recorded touches."""
    target = table.targets[letter]
    most, rounds = table.recipe_run.recipe.rows["frames"], table.recipe_run.recipe.rows["rounds"]
    real = _sample(table.units[target], most)
    known = {**table.scores, **KEPT_SCORES}
    values: dict[str, list[Values]] = {}
    touches: list[NDArray[np.object_]] = []
    by_source: Rows = []
    for done, source in enumerate(table.sources):
        table.recipe_run.tell(done, len(table.sources), f"target {letter}: {source}")
        sample = _sample(table.units[source], most)
        touches.append(sample.touches)
        moved = {n: table.moved(n, sample.pictures, source, target) for n in (AS_RECORDED, *table.methods)}
        for name, scored in _set_values(table, sample, moved, real).items():
            scored |= table.kept(name, moved[name], sample.pictures, source, target)
            values.setdefault(name, []).append(scored)
            scores = summarised(scored, sample.touches, rounds, known)
            by_source.append(_row(table, f"{table.titled(letter)}, by source", name, scores, letter, source))
    joined = {name: _joined(scored) for name, scored in values.items()}
    part = f"{table.titled(letter)}, mean over sources"
    return _compared_rows(table, part, letter, joined, np.concatenate(touches), known) + by_source


def _compared_rows(
    table: Alignment, part: str, letter: str, values: Mapping[str, Values], touches: Any, known: Mapping[str, Score]
) -> Rows:
    """Rows of each method's scores, then of their differences to a reference on the same frames."""
    rounds, named = table.recipe_run.recipe.rows["rounds"], table.recipe_run.recipe.rows["against"]
    reference = named or REFERENCE
    rows = [
        _row(table, part, name, summarised(scored, touches, rounds, known), letter) for name, scored in values.items()
    ]
    if reference not in values:
        return rows
    title = difference_part(part, table.title_of(reference))
    return rows + [
        _row(table, title, name, summarised(less, touches, rounds, known), letter)
        for name, less in differences(values, reference).items()
    ]


@dataclass(frozen=True)
class _Sample:
    """Some frames of a unit, with masks from the recorded pictures, so that no method influences where it is scored."""

    pictures: PictureArray
    masks: NDArray[np.bool_]
    touches: NDArray[np.object_]


def _sample(unit: UnitFrames, most: int) -> _Sample:
    """Evenly spaced frames of a unit, at most ``most``."""
    numbers = spread_evenly(len(unit), most)
    pictures = unit.pictures(numbers)
    return _Sample(pictures, contact_region(pictures, unit.background), unit.touches[numbers])


def _set_values(
    table: Alignment, sample: _Sample, moved: Mapping[str, PictureArray], real: _Sample
) -> dict[str, Values]:
    """Scores of each method's pictures by method; all are scored together, so that the target is processed once."""
    pictures, masks = np.concatenate(list(moved.values())), np.concatenate([sample.masks] * len(moved))
    regions = {"": (None, None), MASKED: (masks, real.masks)}
    scored: Values = {}
    for name, score in table.scores.items():
        if score is table.style:
            distances = style_distances(name, pictures, real.pictures, list(regions.values()), table.weights)
            scored |= dict(zip([f"{name}{where}" for where in regions], distances, strict=True))
            continue
        for where, inside in regions.items():
            scored[f"{name}{where}"] = score.compute(pictures, real.pictures, *inside)
    parts = {name: np.split(values, len(moved)) for name, values in scored.items()}
    return {method: {name: part[place] for name, part in parts.items()} for place, method in enumerate(moved)}


def _paired_rows(table: Alignment, letter: str) -> Rows:
    """Rows that compare every method's pictures with the target's own of the same touches; none without pairs."""
    target = table.targets[letter]
    most = table.recipe_run.recipe.rows["pairs"]
    values: dict[str, list[Values]] = {}
    touches: list[str] = []
    for done, source in enumerate(table.sources):
        table.recipe_run.tell(done, len(table.sources), f"paired truth, {letter}: {source}")
        source_unit, target_unit = table.units[source], table.units[target]
        ours, theirs = paired_frames(source_unit, target_unit, most)
        for touch in dict.fromkeys(source_unit.touches[ours]):
            mine = source_unit.touches[ours] == touch
            pictures, truth = source_unit.pictures(ours[mine]), target_unit.pictures(theirs[mine])
            touches += [touch] * len(truth)
            for name in (AS_RECORDED, *table.methods):
                moved = table.moved(name, pictures, source, target)
                untouched = table.moved(name, source_unit.background[None], source, target)[0]
                scored = paired_values(moved, truth, target_unit.background, untouched, table.style)
                scored |= table.kept(name, moved, pictures, source, target)
                values.setdefault(name, []).append(scored)
    known = {**PAIRED_SCORES, table.style.name: table.style}
    joined = {name: _joined(scored) for name, scored in values.items()}
    part = f"paired truth, to {table.titled(letter)}"
    return _compared_rows(table, part, letter, joined, np.array(touches, object), known)


def _joined(values: list[Values]) -> Values:
    """Scores of several sources, one after the other."""
    return {name: np.concatenate([scores[name] for scores in values]) for name in values[0]}


def _row(table: Alignment, part: str, name: str, scores: Any, letter: str, source: str = "") -> dict[str, Any]:
    """A row of the table, titled by its source, method and variant."""
    title = table.title_of(name)
    words = f"{source}, {title}" if source else title
    return {"part": part, "method": words, "transfer": name, "target": letter, "source": source, "scores": scores}
