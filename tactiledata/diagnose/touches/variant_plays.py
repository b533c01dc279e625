"""Plays of gels and indenters that differ from the nominal ones, at finite strain or by the linear engine.

Every play is kept on disk and not made again.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tactiledata.calibrate.plays.kept_plays import Play, play_path
from tactiledata.calibrate.plays.play_batches import effort_of, played_or_kept
from tactiledata.diagnose.touches.missing_frames import solved
from tactiledata.effects import EFFECTS
from tactiledata.effects.base import Effect
from tactiledata.effects.touch.gel_variants import variant_engine, warped
from tactiledata.effects.touch.response import GelVariant
from tactiledata.gel.contact.history import GelTouch
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.gel.engines.fem import Fidelity
from tactiledata.gel.mesh.pad import PadMesh
from tactiledata.indenters.scaled import scaled

MOST_LOST = 0.1
"""Largest share of the frames that a variant may fail to solve.

If it fails in more, the variant is left out; otherwise, the frames are interpolated.
"""


@dataclass(frozen=True)
class VariantBatch:
    """Touches that are played with one variant of gel or indenter, at one nu and one mu.

    Parameters
    ----------
    mesh : PadMesh
        Nominal mesh of the gel.
    fidelity : "finite-strain" or "linear"
        Mechanics of the gel engine.
    ratio, friction : float
        Poisson's ratio nu and friction coefficient mu.
    variant : GelVariant
        How gel or indenter differ from the nominal ones.
    touches : tuple of GelTouch
        With the nominal indenters.
    """

    mesh: PadMesh
    fidelity: Fidelity
    ratio: float
    friction: float
    variant: GelVariant
    touches: tuple[GelTouch, ...]

    def __str__(self) -> str:
        return f"plays of {len(self.touches)} touches, {self.words}"

    @property
    def words(self) -> str:
        """What the batch plays, in words: touches of the nominal gel are those whose paths are moved."""
        return "moved along the gel" if self.variant == GelVariant() else "gels and indenters that differ"

    @property
    def effort(self) -> float:
        """About how long it takes, in frames of the linear engine."""
        return effort_of(self.touches, self.fidelity == "linear", self.ratio)

    @property
    def paths(self) -> list[Path]:
        """File in which the play of each touch is kept."""
        variant = self.variant
        digest = warped(self.mesh, variant).digest
        law = (variant.c20, variant.c30, variant.skin, variant.spots)
        # shapes of pad and indenter are part of their digests; the law of the material is not
        mechanics = self.fidelity if law == (0.0, 0.0, 0.0, ()) else f"{self.fidelity} {law!r}"
        return [play_path(touch, digest, mechanics, self.ratio, self.friction) for touch in self._scaled]

    def play(self) -> list[Play]:
        """Return the play of each touch, from disk where it was made before."""
        return played_or_kept(
            self._scaled,
            self.paths,
            GelMaterial(1.0, self.ratio, self.friction),
            lambda: variant_engine(self.mesh, self.ratio, self.fidelity, self.variant),
        )

    @property
    def _scaled(self) -> tuple[GelTouch, ...]:
        """Touches with the indenters scaled as the variant says."""
        scale = self.variant.indenter_scale
        if scale == 1.0:
            return self.touches
        return tuple(GelTouch(scaled(touch.indenter, scale), touch.poses) for touch in self.touches)


def design_variants(effect: Effect) -> tuple[GelVariant, ...]:
    """Return the variants that must have been played before an effect can be simulated; most effects need none."""
    return tuple(effect.variant({name: place}) for name, places in effect.designs.items() for place in places)


def variants_of(names: Iterable[str]) -> tuple[GelVariant, ...]:
    """Return the variants that the effects of these names need, each once."""
    return tuple(dict.fromkeys(variant for name in names for variant in design_variants(EFFECTS[name]())))


def has_own_law(variant: GelVariant) -> bool:
    """Return whether a variant has another elastic law, which the linear engine does not know."""
    return (variant.c20, variant.c30) != (0.0, 0.0)


def is_solvable(varied: Sequence[Play], plain: Sequence[Play]) -> bool:
    """Return whether a variant solves nearly all frames which the nominal gel solves; see ``MOST_LOST``.

    Parameters
    ----------
    varied : sequence of Play
        Plays of the variant, one for each touch.
    plain : sequence of Play
        Plays of the nominal gel by the same engine at the same nu and mu, in the same order.
    """
    known = np.concatenate([solved(play) for play in plain])
    lost = known & ~np.concatenate([solved(play) for play in varied])
    return bool(lost.sum() <= MOST_LOST * known.sum())
