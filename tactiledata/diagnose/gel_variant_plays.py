"""Plays of touches with gels and indenters that differ from the nominal ones, kept on disk like all others."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from tactiledata.calibrate.kept_plays import Play
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
    variant, ratio = batch.variant, batch.ratio
    mesh = warped(batch.mesh, variant)
    touches = batch.touches
    if variant.indenter_scale != 1.0:
        touches = tuple(GelTouch(scaled(one.indenter, variant.indenter_scale), one.poses) for one in touches)
    law = (variant.c20, variant.c30, variant.skin, variant.spots)
    # what is of the pad's and the indenter's shape is told by their digests
    mechanics = batch.fidelity if law == (0.0, 0.0, 0.0, ()) else f"{batch.fidelity} {law!r}"
    return played_or_kept(
        touches,
        GelMaterial(1.0, ratio, batch.friction),
        mesh.digest,
        mechanics,
        lambda: variant_engine(batch.mesh, ratio, batch.fidelity, variant),
    )
