"""Plays of touches with gels and indenters that differ from the nominal ones, kept on disk like all others."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from tactiledata.calibrate.kept_plays import Play, play_path
from tactiledata.calibrate.player import played_or_kept
from tactiledata.effects import EFFECTS
from tactiledata.effects.base import Effect
from tactiledata.effects.gel_variants import variant_engine, warped
from tactiledata.effects.response import GelVariant
from tactiledata.gel.fem import Fidelity
from tactiledata.gel.history import GelTouch
from tactiledata.gel.material import GelMaterial
from tactiledata.gel.pad import PadMesh
from tactiledata.indenters.scaled import scaled


@dataclass(frozen=True)
class VariantBatch:
    """Touches to be played with one variant, at one nu and one mu."""

    mesh: PadMesh
    fidelity: Fidelity
    ratio: float
    friction: float
    variant: GelVariant
    touches: tuple[GelTouch, ...]


def design_variants(effect: Effect) -> tuple[GelVariant, ...]:
    """What must have been played before an effect can be asked for wrenches; nothing for most."""
    return tuple(effect.variant({name: place}) for name, places in effect.designs.items() for place in places)


def variants_of(names: Iterable[str]) -> tuple[GelVariant, ...]:
    """Of all effects of these names, each once."""
    return tuple(dict.fromkeys(variant for name in names for variant in design_variants(EFFECTS[name]())))


def play_variant(batch: VariantBatch) -> list[Play]:
    """The plays of a batch, in its order."""
    return played_or_kept(
        _touches(batch),
        variant_paths(batch),
        GelMaterial(1.0, batch.ratio, batch.friction),
        lambda: variant_engine(batch.mesh, batch.ratio, batch.fidelity, batch.variant),
    )


def variant_paths(batch: VariantBatch) -> list[Path]:
    """Return the files in which the plays of a batch are kept, in its order."""
    variant = batch.variant
    digest = warped(batch.mesh, variant).digest
    law = (variant.c20, variant.c30, variant.skin, variant.spots)
    # what is of the pad's and the indenter's shape is told by their digests
    mechanics = batch.fidelity if law == (0.0, 0.0, 0.0, ()) else f"{batch.fidelity} {law!r}"
    return [play_path(touch, digest, mechanics, batch.ratio, batch.friction) for touch in _touches(batch)]


def _touches(batch: VariantBatch) -> tuple[GelTouch, ...]:
    """The touches of a batch with the indenters of its variant."""
    scale = batch.variant.indenter_scale
    if scale == 1.0:
        return batch.touches
    return tuple(GelTouch(scaled(touch.indenter, scale), touch.poses) for touch in batch.touches)
