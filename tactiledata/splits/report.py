"""What a split came out as: counts by partition and stratum, and what stands out, in words."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from numpy.typing import NDArray

from tactiledata.contract.wording import counted
from tactiledata.splits.assign import describe_held
from tactiledata.splits.options import EXCLUDED, PARTITIONS, SHARES, SplitOptions
from tactiledata.splits.shares import astray_note, filling_seeds, group_sizes

MANY = 10
"""Names listed in a note before it says how many more there are."""
SEED_WAY_OUT = "try another seed (--seed N --replace), or add data"
"""What to do where chance fills no part and no seed is known that does."""
DERIVED_WAY_OUT = "add data: with another seed, they would stand apart from the trajectories that they derive from"
"""What to do where the parents lie in another store, whose split has this seed."""


@dataclass(frozen=True)
class Count:
    """Trajectories, and the frames taken from them."""

    trajectories: int
    frames: int

    def document(self) -> dict[str, int]:
        """The count as JSON."""
        return {"trajectories": self.trajectories, "frames": self.frames}


@dataclass(frozen=True)
class Stratum:
    """One stratum: its units by kind, and how its trajectories were dealt out."""

    units: Mapping[str, str]
    counts: Mapping[str, Count]

    @property
    def label(self) -> str:
        """Its units in words."""
        return ", ".join(f"{kind} {name or '(unnamed)'}" for kind, name in self.units.items())


@dataclass(frozen=True)
class SplitReport:
    """A split that was made.

    Parameters
    ----------
    name : str
    options : SplitOptions
    held_out : dict, unit kind -> names
    counts : dict, partition -> Count
        All of ``PARTITIONS`` and ``"excluded"``.
    strata : tuple of Stratum
        One for each combination of units that ``by`` names; empty where it names none.
    notes : tuple of str
        What a user ought to know, in words.
    flagged : tuple of str
        Uids of the trajectories that are left out because they are flagged.
    """

    name: str
    options: SplitOptions
    held_out: Mapping[str, tuple[str, ...]]
    counts: Mapping[str, Count]
    strata: tuple[Stratum, ...]
    notes: tuple[str, ...]
    flagged: tuple[str, ...] = ()

    def document(self) -> dict[str, Any]:
        """The report as JSON."""
        return {
            "name": self.name,
            "options": self.options.document(),
            "held_out": {kind: list(names) for kind, names in self.held_out.items()},
            "counts": {part: count.document() for part, count in self.counts.items()},
            "strata": [
                {"units": dict(s.units), "counts": {part: count.document() for part, count in s.counts.items()}}
                for s in self.strata
            ],
            "flagged": list(self.flagged),
            "notes": list(self.notes),
        }

    def lines(self) -> list[str]:
        """The report for people."""
        total = sum(count.trajectories for count in self.counts.values()) or 1
        rows = [
            f"{part:<12} {counted(count.trajectories, 'trajectory'):>20} ({count.trajectories / total:.1%}), "
            f"{counted(count.frames, 'frame')}"
            for part, count in self.counts.items()
            if part != EXCLUDED or count.trajectories
        ]
        return [
            f"split {self.name!r}: held out: {describe_held(self.held_out)}",
            *rows,
            *(f"- {n}" for n in self.notes),
        ]


def count_parts(table: pa.Table) -> dict[str, Count]:
    """Trajectories and frames of each partition and of ``"excluded"``."""
    partition = np.asarray(table["partition"].to_pylist(), object)
    frames = table["frames"].to_numpy()
    found = {}
    for part in (*PARTITIONS, EXCLUDED):
        rows = partition == part
        found[part] = Count(int(rows.sum()), int(frames[rows].sum()))
    return found


def count_strata(table: pa.Table, kinds: tuple[str, ...]) -> tuple[Stratum, ...]:
    """How each combination of units was dealt out, sorted by name."""
    if not kinds:
        return ()
    grouped = table.group_by([*kinds, "partition"]).aggregate([("frames", "sum"), ("frames", "count")]).to_pylist()
    found: dict[tuple[str, ...], dict[str, Count]] = {}
    for row in grouped:
        units = tuple(row[kind] for kind in kinds)
        found.setdefault(units, {})[row["partition"]] = Count(row["frames_count"], row["frames_sum"])
    return tuple(
        Stratum(
            dict(zip(kinds, units, strict=True)), {p: found[units].get(p, Count(0, 0)) for p in (*PARTITIONS, EXCLUDED)}
        )
        for units in sorted(found)
    )


def notes_on(
    table: pa.Table,
    options: SplitOptions,
    held_out: Mapping[str, tuple[str, ...]],
    counts: Mapping[str, Count],
    strata: tuple[Stratum, ...],
    flagged: Collection[str] = (),
) -> list[str]:
    """Return what stands out in a split.

    That is parts that are empty or far from their shares, strata with holes, unnamed units, trajectories in no part.

    Parameters
    ----------
    table : pa.Table
        ``SPLIT_SCHEMA``
    options : SplitOptions
        Options of the split.
    held_out : dict, unit kind -> names
        Sensors and indenters that are held out.
    counts : dict, part -> Count
        Trajectories and frames of each part.
    strata : tuple of Stratum
        Counts of each stratum.
    flagged : collection of str
        Uids that are left out because they are flagged; `flagged.flag_notes` has the words for them.
    """
    wanted = [part for part, share in zip(SHARES, options.fractions, strict=True) if share > 0]
    # which units `auto` holds out goes by the seed, so that counts with another seed can only be told without
    known = set(table["uid"].to_pylist())
    orphans = len({root for root in table["root"].to_pylist() if root not in known})
    # and what was derived is drawn as its parents are elsewhere: another seed would part it from them
    is_free = not orphans and (options.hold_out != "auto" or not held_out)
    filled = [part for part in wanted if counts[part].trajectories]
    hint = DERIVED_WAY_OUT if orphans else SEED_WAY_OUT
    notes = [*_part_notes(table, options, counts, wanted, is_free, hint), *_thin_strata(strata, filled)]
    notes += _excluded(table.filter(pc.invert(pc.is_in(table["uid"], value_set=pa.array(list(flagged), pa.string())))))
    for kind in ("sensor", "indenter"):
        unnamed = table[kind].to_pylist().count("")
        if unnamed:
            notes.append(f"trajectories that name no {kind}: {unnamed}; nobody knows whether it is a held-out one")
    if orphans:
        notes.append(
            f"some trajectories derive from {counted(orphans, 'parent trajectory')} that this store does not hold; "
            "they are drawn as their parents are where those lie, given the same seed, fractions and hold-out"
        )
    silent = table.num_rows - int(np.count_nonzero(table["frames"].to_numpy()))
    if silent:
        notes.append(f"trajectories without a frame that the split takes (see the contact filter, --force): {silent}")
    return notes


def _excluded(table: pa.Table) -> list[str]:
    left_out = table.filter(pc.equal(table["partition"], EXCLUDED))
    recorded = int(pc.sum(pc.equal(left_out["root"], left_out["uid"]), min_count=0).as_py())
    derived = left_out.num_rows - recorded
    notes = []
    if recorded:
        notes.append(
            f"in no part: {counted(recorded, 'recorded trajectory')} of the same moments as others, which stand in "
            "several parts or do not carry the same held-out unit"
        )
    if derived:
        notes.append(
            f"in no part: {counted(derived, 'derived trajectory')} with a held-out unit, derived from what is in "
            "train, val or test, or in no part"
        )
    return notes


def _part_notes(
    table: pa.Table,
    options: SplitOptions,
    counts: Mapping[str, Count],
    wanted: list[str],
    is_free: bool,
    hint: str = SEED_WAY_OUT,
) -> list[str]:
    drawn = np.isin(np.asarray(table["partition"].to_pylist(), object), SHARES)
    has_frames = drawn & (table["frames"].to_numpy() > 0)
    notes = [
        f"{part} has {counted(counts[part].trajectories, 'trajectory')} and no frames"
        + (_way_out(table, has_frames, " with frames", options, len(wanted), is_free, hint) if has_frames.any() else "")
        for part in wanted
        if counts[part].trajectories and not counts[part].frames
    ]
    empty = [part for part in wanted if not counts[part].trajectories]
    if empty:
        way_out = _way_out(table, drawn, "", options, len(wanted), is_free, hint)
        notes.append(f"{' and '.join(empty)} got no trajectory{way_out}")
    dealt = [counts[part].trajectories for part in SHARES]
    if not notes and any(dealt) and (astray := astray_note(dealt, group_sizes(table, drawn), options, is_free)):
        notes.append(astray)
    return notes


def _way_out(
    table: pa.Table, taken: NDArray[np.bool_], what: str, options: SplitOptions, n_wanted: int, is_free: bool, hint: str
) -> str:
    """Why the rows that were taken leave a part without something, and what to do."""
    groups = group_sizes(table, taken)
    if len(groups) < n_wanted:
        few = f"{counted(len(groups), 'group')}{what} cannot fill {n_wanted} parts"
        return f": {few}; add data, or ask for fewer parts with --fractions"
    seeds = filling_seeds(groups, options) if is_free else []
    if seeds:
        others = f" (and so do {' and '.join(map(str, seeds[1:]))})" if seeds[1:] else ""
        hint = f"the same command with --seed {seeds[0]} --replace fills every part{others}"
    return f": {counted(len(groups), 'group')}{what} are few for chance to fill every part; {hint}"


def _thin_strata(strata: tuple[Stratum, ...], wanted: list[str]) -> list[str]:
    notes = []
    for part in wanted:
        thin = [
            stratum.label
            for stratum in strata
            if stratum.counts[part].trajectories == 0 < sum(stratum.counts[p].trajectories for p in SHARES)
        ]
        if thin:
            more = f" and {len(thin) - MANY} more" if len(thin) > MANY else ""
            notes.append(f"{part} has no trajectory of: {'; '.join(thin[:MANY])}{more} (of {len(strata)} strata)")
    return notes
