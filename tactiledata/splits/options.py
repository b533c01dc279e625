"""What a split was asked to be: options, checked, and as people type them."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from tactiledata.contract.paths import need_file_name
from tactiledata.errors import UnknownName, UsageError
from tactiledata.splits.groups import UNIT_KINDS

HoldOut = Literal["auto", "none"] | Mapping[str, Sequence[str]]
SHARES = ("train", "val", "test")
"""Partitions that the draw fills, in the order of the fractions."""
PARTITIONS = (*SHARES, "test_unseen")
EXCLUDED = "excluded"
"""In no partition: a derived trajectory that carries a held-out unit while its parent does not."""
FRACTION_TOLERANCE = 1e-6
"""How far the fractions' sum may be from 1: typed decimals, not a missing tenth."""
BY_WORDS = ("trajectory", *UNIT_KINDS)
"""What a split may go by."""
FRAME_WORDS = {"frame", "frames", "image", "images", "row", "rows", "time"}


@dataclass(frozen=True)
class SplitOptions:
    """Options of a split; `checked` builds them from what a caller gave.

    Parameters
    ----------
    by : tuple of str
        ``"trajectory"`` and the unit kinds that make strata.
    hold_out : "auto", "none" or dict, unit kind -> names
    fractions : (3,) float
        Shares of train, val and test, by trajectories; they sum to 1.
    force : (lowest, highest) N, or None
        Frames whose contact force lies outside are in no partition; ``None`` takes every frame.
    seed : int
    with_flagged : bool
        Whether flagged trajectories are taken; they are in no partition otherwise.
    """

    by: tuple[str, ...] = ("trajectory", "sensor")
    hold_out: HoldOut = "auto"
    fractions: tuple[float, float, float] = (0.8, 0.1, 0.1)
    force: tuple[float, float] | None = (1.0, 13.0)
    seed: int = 0
    with_flagged: bool = False

    @classmethod
    def checked(
        cls,
        by: Sequence[str] | str = ("trajectory", "sensor"),
        hold_out: HoldOut | str | None = "auto",
        fractions: Sequence[float] | str = (0.8, 0.1, 0.1),
        force: Sequence[float] | str | None = (1.0, 13.0),
        seed: int = 0,
        with_flagged: bool = False,
    ) -> SplitOptions:
        """Return options that make sense; texts are read as the command line reads them.

        Parameters
        ----------
        by : sequence of str, or str
            "trajectory" and the unit kinds that make strata.
        hold_out : "auto", "none", dict of unit kind -> names, or str
            Sensors and indenters that are held out.
        fractions : sequence of float, or str
            Shares of train, val and test.
        force : (float, float), N, or str, optional
            Lowest and highest contact force of the frames that are taken; ``None`` takes all.
        seed : int
            Seed of the draw.
        with_flagged : bool
            Whether flagged trajectories are taken, too.

        Raises
        ------
        UsageError
            Options that make none, or that would leak.
        """
        if isinstance(seed, bool) or not isinstance(seed, int):
            raise UsageError(f"seed is {seed!r}", "a whole number", "For example --seed 0.")
        read = read_by(by), read_hold_out(hold_out), read_fractions(fractions), read_force(force)
        return cls(*read, seed, with_flagged)

    @property
    def strata(self) -> tuple[str, ...]:
        """The unit kinds that make strata."""
        return tuple(kind for kind in self.by if kind != "trajectory")

    def document(self) -> dict[str, Any]:
        """The options as ``schemas/split.json`` states them."""
        hold_out = self.hold_out
        return {
            "by": list(self.by),
            "hold_out": hold_out if isinstance(hold_out, str) else {k: list(v) for k, v in hold_out.items()},
            "fractions": list(self.fractions),
            "force": None if self.force is None else list(self.force),
            "seed": self.seed,
            # stated only where it is so: documents from before there were flags say the same by saying nothing
            **({"with_flagged": True} if self.with_flagged else {}),
        }


def read_by(value: Sequence[str] | str) -> tuple[str, ...]:
    """What a split goes by: ``"trajectory,sensor,indenter"`` or the words one by one.

    Raises
    ------
    UsageError
        By frames, or without trajectories: both leak.
    UnknownName
        By what no split goes by.
    """
    words = [word.strip() for word in (value.split(",") if isinstance(value, str) else list(value))]
    words = [word for word in dict.fromkeys(words) if word]
    for word in words:
        if word not in (*BY_WORDS, *FRAME_WORDS):
            raise UnknownName("--by", word, BY_WORDS)
    leaky = [word for word in words if word in FRAME_WORDS]
    if leaky or "trajectory" not in words:
        asked = ",".join(words) or "nothing"
        raise UsageError(
            f"a split by {asked} would tear trajectories apart: neighbouring frames of one touch differ by 0.1 mm and "
            "share their noise, so a test frame would have near copies in train and every score would be too good",
            "--by with trajectory in it",
            "Use --by trajectory,sensor or --by trajectory,sensor,indenter.",
            by=words,
        )
    return ("trajectory", *(kind for kind in UNIT_KINDS if kind in words))


def read_hold_out(value: HoldOut | str | None) -> HoldOut:
    """What is held out: ``"auto"``, ``"none"``, a mapping, or ``"sensor=A,B;indenter=x"``.

    Items are parted by commas or semicolons; one without ``=`` goes on with the kind before it, and a kind may be
    repeated. Names that hold a comma, a semicolon or an equals sign need the mapping.

    Examples
    --------
    >>> read_hold_out("sensor=D20542,indenter=star,cross")
    {'sensor': ('D20542',), 'indenter': ('cross', 'star')}
    """
    if value is None or value == "none" or value == "auto":
        return "none" if value is None else value  # type: ignore[return-value]
    if isinstance(value, Mapping):
        pairs = [(kind, name) for kind, names in value.items() for name in _names(kind, names)]
    else:
        pairs = _typed_pairs(str(value))
    if not pairs:
        raise UsageError(
            f"--hold-out {value!r} names no unit",
            "auto, none, or for example sensor=D20542,indenter=star",
            "Use --hold-out none to hold nobody out.",
        )
    held: dict[str, tuple[str, ...]] = {}
    for kind, name in pairs:
        if kind not in UNIT_KINDS:
            raise UnknownName("kind of unit to hold out", kind, UNIT_KINDS)
        held[kind] = tuple(dict.fromkeys((*held.get(kind, ()), name)))
    return {kind: tuple(sorted(held[kind])) for kind in UNIT_KINDS if kind in held}


def _names(kind: str, names: Sequence[str]) -> list[str]:
    listed = [names] if isinstance(names, str) else list(names)
    if any(not isinstance(name, str) or not name for name in listed):
        raise UsageError(f"--hold-out of {kind} names {listed!r}", "names that are not empty")
    return listed


def _typed_pairs(text: str) -> list[tuple[str, str]]:
    pairs: list[tuple[str, str]] = []
    kind = ""
    for item in re.split("[,;]", text):
        head, has_kind, tail = item.partition("=")
        kind, name = (head.strip(), tail.strip()) if has_kind else (kind, item.strip())
        if not kind or not name:
            raise UsageError(
                f"--hold-out {text!r} has the item {item.strip()!r}",
                "auto, none, or for example sensor=D20542,indenter=star",
                "Name the kind and the unit: sensor=…, indenter=….",
            )
        pairs.append((kind, name))
    return pairs


def read_fractions(value: Sequence[float] | str) -> tuple[float, float, float]:
    """Shares of train, val and test: three numbers, or ``"0.8,0.1,0.1"``.

    Raises
    ------
    UsageError
        Not three finite shares of at least 0 that sum to 1.
    """
    try:
        shares = [float(share) for share in (value.split(",") if isinstance(value, str) else value)]
    except (TypeError, ValueError) as error:
        raise UsageError(f"fractions are {value!r}", "three numbers", "For example --fractions 0.8,0.1,0.1.") from error
    good = len(shares) == 3 and all(math.isfinite(share) and share >= 0 for share in shares)
    if not good or abs(sum(shares) - 1) > FRACTION_TOLERANCE:
        total = f" (sum {sum(shares):.6g})" if len(shares) == 3 else f" ({len(shares)} numbers)"
        raise UsageError(
            f"fractions are {shares}{total}",
            "shares of train, val and test, none negative, that sum to 1",
            "For example --fractions 0.8,0.1,0.1.",
            fractions=shares,
        )
    return shares[0], shares[1], shares[2]


def read_force(value: Sequence[float] | str | None) -> tuple[float, float] | None:
    """Lowest and highest contact force in newtons, or ``"1..13"``; ``None`` or ``"none"`` for no filter.

    Raises
    ------
    UsageError
        Not two numbers in order, or NaN.
    """
    if value is None or value == "none":
        return None
    try:
        low, high = (float(bound) for bound in (value.split("..") if isinstance(value, str) else value))
    except (TypeError, ValueError) as error:
        raise UsageError(
            f"force is {value!r}",
            "two numbers in newtons with two points between them, or none",
            "For example --force 1..13 or --force none.",
        ) from error
    if not (math.isfinite(low) and math.isfinite(high) and 0 <= low < high):
        raise UsageError(
            f"force is {low:g}..{high:g} N",
            "finite numbers, 0 <= lowest < highest, in newtons",
            "For example --force 1..13 or --force none.",
            force=(low, high),
        )
    return low, high


def check_name(name: str) -> str:
    """A split's name that is safe as a file name.

    Raises
    ------
    UsageError
        Anything else: paths, spaces, dots (other files about a split carry its name and a dot).
    """
    return need_file_name(name, "split", "default")
