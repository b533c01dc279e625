"""Where development worlds differ from their simulation: what locators say without a catalogue, against the truth.

    python benchmarks/locating_worlds.py [--quick] [--mounts M] [--count K] [--only EFFECT ...] [--nulls L]
                                         [--bank FOLDER] [--out FILE.jsonl]

The worlds are those of benchmarks/naming_worlds.py. The *axis*, normal to the surface (fz) or along it (shear, and
torques, in which shear shows best), is right where one that certain findings name holds the most of the hidden change,
beyond what a refit of the plain simulation imitates, or nearly the most (from 45 % of it on). A contrast counts as the
axis that holds most of its own energy, a drift of E, nu or the contact offset as normal, one of mu as along, a drift of
the zeros, where that is hidden, as what it moves. *Where* is right if a certain finding names a covariate, a phase or
an event, or the zeros follow what, `SHOWS_IN` has, as physics says and before anything was run; how many names are told
altogether says how much that is worth. Worlds that hide nothing are the control: locators should find no structure
there. The cases of sealed proofs are asked about by `proof_located`.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from naming_asked import Asked, asked_cases
from naming_worlds import Bench
from numpy.typing import NDArray

from tactiledata.diagnose.locate.locate import LEVEL, LocatorResults
from tactiledata.diagnose.naming.joint_fit import plain_fit
from tactiledata.diagnose.naming.options import NamingOptions
from tactiledata.diagnose.touches.whitened import WhitenedTouches
from tactiledata.diagnose.unseen.touch_residuals import COMPONENTS, locate_touches
from tactiledata.diagnose.zeros.causes import zero_causes
from tactiledata.prove.cases.kinds import LEAST_SIGNAL
from tactiledata.prove.worlds.plan import WorldPlan
from tactiledata.prove.worlds.played_plan import START

Array = NDArray[np.float64]

PLACE = {"x", "y", "distance from the middle", "map", "sensor"}
SIZE = {"contact radius", "depth", "normal force", "indenter"}
SLIDES = {"contact", "slip onset", "end of slip", "shear start", "shear travel", "shear reversal", "lateral speed"}
GRAVITY = {f"gravity along {axis} since the zero" for axis in "xyz"}
SHOWS_IN: Mapping[str, set[str]] = {
    "relaxation": {"seconds", "dwell start", "reversal", "loading rate", "time step", "phase"},
    "mullins": {"share of the largest depth", "earlier depth", "earlier contacts", "reversal", "phase"},
    "stiffening": SIZE,
    "thickness": SIZE,
    "dome": PLACE,
    "adhesion": {"separation", "contact radius", "indenter", "phase"},
    "shear_strength": SIZE | SLIDES,
    "rate_friction": {"lateral speed", *SLIDES, "phase"},
    "ageing_friction": {"seconds", *SLIDES, "phase"},
    "partial_slip": {*SLIDES, "phase"},
    "arm_compliance": {"normal force", "last joint", "depth"},
    "stem_bending": {"indenter", *SLIDES, "phase"},
    "ft_drift": {"free air", "zeros: sensor_drift", "time since power-on", "index"},
    "cross_talk": {"normal force", "depth", "contact radius", *SLIDES},
    "tool_weight": {"free air", "zeros: tool_weight", "tilt", *GRAVITY},
    "cable_drag": {"free air", "zeros: cable_drag", "last joint"},
    "frame_rotation": {"normal force", "depth", "contact radius", *SLIDES},
    "lag": {"loading rate", "time step", "reversal", "dwell start", "lateral speed", "phase"},
    "clock_skew": {"loading rate", "time step", "reversal", "dwell start", "seconds", "index", "phase"},
    "indenter_mount": {"indenter", "mount", "contact onset", "depth"},
    "warm_up": {"time since power-on", "index"},
    "wear": {"earlier contacts", "index"},
    "delamination": PLACE | SLIDES,
    "pad_edge": PLACE,
    "skin": SIZE,
    "dead_band": {"normal force", "contact onset", "separation", "depth", "contact radius", "phase", *SLIDES},
    "saturation": {"normal force", "depth", "contact radius", "indenter"},
    "inertia": {"time step", "contact onset", "dwell start", "shear start", "reversal", "phase"},
}
ALONG = ("fx", "fy", "tx", "ty", "tz", "shear along the slide", "torque of shear along the slide")
AXES = {"fz": "normal"} | dict.fromkeys(ALONG, "along")
OF_PARAMETER = {"E": "normal", "nu": "normal", "mu": "along", "contact offset": "normal"}
NEARLY_MOST = 0.45
"""Of a hidden change, with which an axis is not a wrong one."""


def axes_of(change: Array, weighed: Array) -> dict[str, float]:
    """Shares of a hidden change (N, 6) in the groups of components, in the metric of ``weighed``."""
    energy = np.maximum((change * weighed).sum(axis=0), 0.0)
    shares = energy / max(energy.sum(), 1e-300)
    return grouped(dict(zip(COMPONENTS, shares.tolist(), strict=True)))


def grouped(shares: Mapping[str, float]) -> dict[str, float]:
    """Shares of components, added up in their groups."""
    groups = dict.fromkeys(dict.fromkeys(AXES.values()), 0.0)
    for component, share in shares.items():
        groups[AXES[component]] += share
    return groups


def told(located: LocatorResults) -> tuple[set[str], set[str]]:
    """Groups of components, and covariates, phases and events, that certain findings name."""
    axes, where = set(), set()
    if located.is_certain("drifting parameters"):
        axes |= {OF_PARAMETER[one.parameter] for one in located.leading if one.parameter in OF_PARAMETER}
        where |= {name for one in located.leading for name in (one.covariate, *one.alike)}
    if located.is_certain("trajectories' own parameters"):
        strongest = located.own[0]
        axes.add(OF_PARAMETER[strongest.parameter])
        where |= {strongest.covariate, *strongest.alike}
    if located.is_certain("contrasts"):
        certain = [one for one in located.contrasts if one.p <= LEVEL]
        axes |= {_axis(one.shares) for one in certain}
        where |= {name for one in certain for name in (one.along, *one.alike, *one.alternatives)}
    if located.is_certain("departures from events on"):
        departures = [one for one in located.by_table["departures from events on"] if one.p <= LEVEL]
        axes |= {AXES[one.component] for one in departures}
        where |= {one.event for one in departures}
    if located.is_certain("events"):
        clusters = [(one.event, each) for one in located.events for each in one.clusters if each.p <= LEVEL]
        axes |= {AXES[each.component] for _, each in clusters}
        where |= {event for event, _ in clusters}
    if located.is_certain("the tree"):
        leaves = [one for one in located.by_table["the tree"] if one.p <= LEVEL]
        axes |= {AXES[one.component] for one in leaves}
        words = " and ".join(one.conditions for one in leaves)
        where |= {name for name in _known(located) if name in words}
    sharpest = located.energy.sharpest
    if located.is_structured and sharpest is not None:
        axes |= {AXES[word] for word in sharpest.words.replace(",", "").split() if word in AXES}
        where |= set(sharpest.factors)
    if located.is_certain("the map"):
        where.add("map")
    if located.is_certain("free air"):
        where.add("free air")
    return axes, where


def _axis(shares: Mapping[str, float]) -> str:
    """The group of components that holds most."""
    groups = grouped(shares)
    return max(groups, key=lambda one: groups[one])


def _known(located: LocatorResults) -> list[str]:
    residuals = located.projection.residuals
    return [name for name in (*residuals.covariates, *residuals.labels) if len(name) > 1]


def run(bench: Bench, asked: Asked) -> dict[str, Any]:
    """One world from the rig to what locators say of it."""
    gel = bench.gel(asked.seed)
    recorded = bench.maker.recorded(asked.seed, gel, asked.hidden)
    white = WhitenedTouches.of(bench.maker.cases(recorded, bench.family), NamingOptions().errors)
    base = plain_fit(white, START)
    located = locate_touches(white, base)
    change = white.whiten(bench.felt(asked, gel) - bench.clean(asked.seed, gel))
    shares = axes_of(change, base.metric.weigh(change[:, :, None])[:, :, 0])
    axes, where = told(located)
    shows_in = SHOWS_IN.get(asked.effects[0], set()) if asked.effects else set()
    for cause in zero_causes(recorded.zeros, band=recorded.dead_band):
        where.add(f"zeros: {cause.effect}")
        # zeros of every world drift a little: that says nothing of other effects
        if f"zeros: {cause.effect}" in shows_in:
            axes |= {AXES[component] for component in cause.values if component in AXES}
    name = asked.effects[0] if asked.effects else ""
    return {
        "case": asked.label,
        "effect": name,
        "signal": float(np.sqrt(max(base.metric.cost(change), 0.0))),
        "is_structured": located.is_structured,
        "axes": shares,
        "found_axes": sorted(axes),
        "found": sorted(where),
        "is_axis": any(shares[one] >= NEARLY_MOST for one in axes),
        "is_where": bool(where & shows_in),
        "sentences": located.sentences(),
    }


def line(one: Mapping[str, Any]) -> str:
    """A world's."""
    axis = max(one["axes"], key=lambda each: one["axes"][each])
    named = ", ".join(sorted(set(one["found"]) & SHOWS_IN[one["effect"]])) or "-"
    right = " and ".join(what for what, is_so in (("axis", one["is_axis"]), ("where", one["is_where"])) if is_so)
    share = f"{100 * one['axes'][axis]:.0f} % in {axis}"
    return f"    {one['effect']}: signal {one['signal']:.0f}, {share}: {right or 'nothing'} right ({named})"


def summary(found: Sequence[Mapping[str, Any]]) -> str:
    """A line a world, those that show most first, and how many are right."""
    nulls, hidden = ([one for one in found if bool(one["effect"]) is is_hidden] for is_hidden in (False, True))
    lines = [line(one) for one in sorted(hidden, key=lambda each: -each["signal"])]
    for what, part in (
        (
            f"whose signal is {LEAST_SIGNAL:.1f} and more",
            [o for o in hidden if o["signal"] >= LEAST_SIGNAL],
        ),
        ("whose signal is less", [o for o in hidden if o["signal"] < LEAST_SIGNAL]),
    ):
        counts = [sum(one[key] for one in part) for key in ("is_structured", "is_axis", "is_where")]
        both = sum(one["is_axis"] and one["is_where"] for one in part)
        lines.append(
            f"{len(part)} worlds {what}: structure in {counts[0]}, axis right in {counts[1]}, where in {counts[2]},"
            f" both in {both}"
        )
    by_world: dict[str, list[bool]] = {}
    for one in hidden:
        if one["signal"] >= LEAST_SIGNAL:
            by_world.setdefault(one["case"].split()[-1], []).append(one["is_axis"] and one["is_where"])
    lines += [f"both in {sum(right)} of {len(right)} of them in worlds {seed}" for seed, right in by_world.items()]
    told_names = [len([name for name in one["found"] if not name.startswith("zeros: ")]) for one in hidden]
    located = [count for count in told_names if count]
    if located:
        lines.append(f"covariates, phases and events told of a world that has any: {np.mean(located):.1f} in the mean")
    lines.append(f"{len(nulls)} worlds that hide nothing: structure in {sum(one['is_structured'] for one in nulls)}")
    return "\n".join(lines)


def main() -> None:
    """Run what is not in the file yet, then the summary."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="ten touches on a coarse linear pad; shows that it works")
    parser.add_argument("--mounts", type=int, default=5, help="of each of the five indenters, a touch each")
    parser.add_argument("--count", type=int, default=1)
    parser.add_argument("--only", nargs="*", default=list(SHOWS_IN), help="of the rig's effects")
    parser.add_argument("--nulls", type=int, default=10)
    parser.add_argument("--out", type=Path)
    parser.add_argument("--bank", type=Path, default=Path(tempfile.gettempdir()) / "tactiledata-rig-bank")
    options = parser.parse_args()
    only = ["frame_rotation"] if options.quick else options.only
    cases = [one for one in asked_cases(("effects",), options.count, "medium") if one.effects[0] in only]
    cases += asked_cases(("nulls",), 1 if options.quick else options.nulls, "none")
    lines = options.out.read_text().splitlines() if options.out and options.out.is_file() else []
    found = [json.loads(line) for line in lines]
    todo = [one for one in cases if one.label not in {each["case"] for each in found}]
    if todo:
        bench = Bench.of(WorldPlan(0, options.quick, options.mounts), options.bank, with_variants=False)
        for asked in todo:
            found.append(run(bench, asked))
            print(f"{asked.label}: {' '.join(found[-1]['sentences'])}", flush=True)
            if options.out:
                with options.out.open("a") as file:
                    file.write(json.dumps(found[-1]) + "\n")
    print(summary(found))


if __name__ == "__main__":
    main()
