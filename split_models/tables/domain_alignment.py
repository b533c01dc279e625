"""The table of domain alignment: pictures of some units, transferred, against the recorded touches of others.

Synth. is what a method makes of a source, beside the source as it was recorded: the paper's Real where it states that
it is real, else what it is (`recorded_row`). Where both units recorded the same touches, each transferred picture is
held against its true one as well.
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
from split_models.tables.paired_truth import PAIRED_SCORES, paired_values
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
SET_SCORES = ("histogram_intersection", "histogram_correlation", STYLE)


@dataclass(frozen=True)
class Alignment:
    """Who is compared with whom, by which methods and scores.

    Parameters
    ----------
    recipe_run : RecipeRun
    methods : dict
        Transfers by name.
    sources : list of str
    targets : dict
        Letter in the table -> sensor.
    scores : dict
        Of two sets of pictures, one style distance among them.
    weights : Path, optional
        Of VGG-19.
    """

    recipe_run: RecipeRun
    methods: Mapping[str, TransferMethod]
    sources: list[str]
    targets: dict[str, str]
    scores: dict[str, Score]
    weights: Path | None

    @cached_property
    def units(self) -> dict[str, UnitFrames]:
        """Frames of every source and target in the parts that the recipe names."""
        parts = [self.recipe_run.frames(part) for part in self.recipe_run.recipe.rows["parts"]]
        return {name: UnitFrames(parts, name) for name in [*self.sources, *self.targets.values()]}

    @property
    def style(self) -> Score:
        """The one style distance that can be had."""
        return next(score for name, score in self.scores.items() if name.startswith(STYLE))

    def moved(self, name: str, pictures: PictureArray, source: str, target: str) -> PictureArray:
        """Pictures of a source as a method gives them to a target; as they are for `AS_RECORDED`."""
        if name == AS_RECORDED:
            return pictures
        return self.methods[name].transfer(pictures, self.units[source].background, self.units[target].background)

    @cached_property
    def recorded_row(self) -> str:
        """The title of rows of pictures as they were recorded."""
        return recorded_row(self.recipe_run.store)

    def titled(self, letter: str) -> str:
        """A target in headings."""
        sensor = self.targets[letter]
        known = sensor in self.recipe_run.frames("train").sensor_names
        return f"{letter}: {sensor}" + (", which the model learned from" if known else "")


def prepare_alignment(recipe_run: RecipeRun) -> Alignment:
    """The image VAE, trained, and what is compared.

    Raises
    ------
    UsageError
        A recipe without sources or targets, or with one sensor as both.
    UnknownName
        A method that does not exist.
    MissingFile
        No weights where the recipe says.
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
        raise UsageError(f"{', '.join(both)} as source and as target", "other units on each side", "Mend the recipe.")
    weights = Path(rows["weights"]) if rows["weights"] else None
    scores = {score.name: score for _, score in chosen_scores(SET_SCORES, weights)}
    methods = {row: _method(recipe_run, row) for row in rows["methods"] or [*LATENT, *PIXEL_TRANSFERS]}
    return Alignment(recipe_run, methods, sources, targets, scores, weights)


def _method(recipe_run: RecipeRun, row: str) -> TransferMethod:
    """The transfer of a row; ``VARIANT:METHOD`` is one with the image VAE of a variant of the recipe."""
    variant, _, name = row.rpartition(":")
    if name in LATENT:
        return vae_transfer(name, recipe_run.variant(variant).image_vae)
    if variant or name not in PIXEL_TRANSFERS:
        raise UnknownName("transfer method" + (" with a model" if variant else ""), name, [*LATENT, *PIXEL_TRANSFERS])
    found: TransferMethod = PIXEL_TRANSFERS[name]
    return found


def alignment_rows(recipe_run: RecipeRun) -> Rows:
    """For each target a row of each method, over all sources and by source; paired truth; latent vectors."""
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
    """Every method's pictures of every source against the target's real touches."""
    target = table.targets[letter]
    most, rounds = table.recipe_run.recipe.rows["frames"], table.recipe_run.recipe.rows["rounds"]
    real = _sample(table.units[target], most)
    values: dict[str, list[Values]] = {}
    touches: list[NDArray[np.object_]] = []
    by_source: Rows = []
    for done, source in enumerate(table.sources):
        table.recipe_run.tell(done, len(table.sources), f"target {letter}: {source}")
        sample = _sample(table.units[source], most)
        touches.append(sample.touches)
        moved = {n: table.moved(n, sample.pictures, source, target) for n in (AS_RECORDED, *table.methods)}
        for name, found in _set_values(table, sample, moved, real).items():
            values.setdefault(name, []).append(found)
            scores = summarised(found, sample.touches, rounds, table.scores)
            by_source.append(_row(table, f"{table.titled(letter)}, by source", name, scores, letter, source))
    over_all = [
        _row(
            table,
            f"{table.titled(letter)}, mean over sources",
            name,
            summarised(_joined(found), np.concatenate(touches), rounds, table.scores),
            letter,
        )
        for name, found in values.items()
    ]
    return over_all + by_source


@dataclass(frozen=True)
class _Sample:
    """Some frames of a unit; masks are of the recorded pictures: no method has a say in where it is judged."""

    pictures: PictureArray
    masks: NDArray[np.bool_]
    touches: NDArray[np.object_]


def _sample(unit: UnitFrames, most: int) -> _Sample:
    numbers = spread_evenly(len(unit), most)
    pictures = unit.pictures(numbers)
    return _Sample(pictures, contact_region(pictures, unit.background), unit.touches[numbers])


def _set_values(
    table: Alignment, sample: _Sample, moved: Mapping[str, PictureArray], real: _Sample
) -> dict[str, Values]:
    """By method: scores of its pictures, all methods at once, so that the target is looked at once."""
    pictures, masks = np.concatenate(list(moved.values())), np.concatenate([sample.masks] * len(moved))
    both = {"": (None, None), MASKED: (masks, real.masks)}
    found: Values = {}
    for name, score in table.scores.items():
        if score is table.style:
            distances = style_distances(name, pictures, real.pictures, list(both.values()), table.weights)
            found |= dict(zip([f"{name}{where}" for where in both], distances, strict=True))
            continue
        for where, inside in both.items():
            found[f"{name}{where}"] = score.compute(pictures, real.pictures, *inside)
    parts = {name: np.split(values, len(moved)) for name, values in found.items()}
    return {method: {name: part[place] for name, part in parts.items()} for place, method in enumerate(moved)}


def _paired_rows(table: Alignment, letter: str) -> Rows:
    """Every method's pictures against the target's own ones of the same touches; none where none are paired."""
    target = table.targets[letter]
    most, rounds = table.recipe_run.recipe.rows["pairs"], table.recipe_run.recipe.rows["rounds"]
    values: dict[str, list[Values]] = {}
    touches: list[str] = []
    for done, source in enumerate(table.sources):
        table.recipe_run.tell(done, len(table.sources), f"paired truth, {letter}: {source}")
        one, other = table.units[source], table.units[target]
        ours, theirs = paired_frames(one, other, most)
        for touch in dict.fromkeys(one.touches[ours]):
            mine = one.touches[ours] == touch
            pictures, truth = one.pictures(ours[mine]), other.pictures(theirs[mine])
            touches += [touch] * len(truth)
            for name in (AS_RECORDED, *table.methods):
                moved = table.moved(name, pictures, source, target)
                untouched = table.moved(name, one.background[None], source, target)[0]
                found = paired_values(moved, truth, other.background, untouched, table.style)
                values.setdefault(name, []).append(found)
    known = {**PAIRED_SCORES, table.style.name: table.style}
    return [
        _row(
            table,
            f"paired truth, to {table.titled(letter)}",
            name,
            summarised(_joined(found), np.array(touches, object), rounds, known),
            letter,
        )
        for name, found in values.items()
    ]


def _joined(found: list[Values]) -> Values:
    return {name: np.concatenate([one[name] for one in found]) for name in found[0]}


def _row(table: Alignment, part: str, name: str, scores: Any, letter: str, source: str = "") -> dict[str, Any]:
    variant, _, method = name.rpartition(":")
    of_variant = f", {variant}" if variant else ""
    title = table.recorded_row if name == AS_RECORDED else f"{title_of(method)}{of_variant} (Synth.)"
    words = f"{source}, {title}" if source else title
    return {"part": part, "method": words, "transfer": name, "target": letter, "source": source, "scores": scores}
