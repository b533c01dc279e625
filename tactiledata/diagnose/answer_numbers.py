"""The numbers of an answer in sentences: those of effects, where E, nu and mu move to, and of what they then are."""

from __future__ import annotations

from collections.abc import Sequence

from tactiledata.diagnose.profiled_interval import Interval
from tactiledata.diagnose.residuals import joined_names
from tactiledata.diagnose.wording import rounded
from tactiledata.effects.setting import EffectSetting

MOST_NUMBERS = 6
"""Of a fit, that are all told; of more only those that are not nothing."""
NEAR_BOUND = 0.01
"""Of the interval, within which a value at its end is at the bound."""
_SCALES = {"E": (1e-3, "kPa"), "nu": (1.0, "1"), "mu": (1.0, "1")}


def numbers_told(found: Sequence[Interval]) -> list[str]:
    """Of the effects, after E, nu and mu; of many only those that are not nothing."""
    fitted = found[3:]
    shown = [one for one in fitted if not one.low <= 0.0 <= one.high] if len(fitted) > MOST_NUMBERS else fitted
    shown = shown or fitted
    numbers = [
        f"{one.name} = {rounded(one.value)} ({rounded(one.low)} to {rounded(one.high)}"
        f"){'' if one.unit == '1' else ' ' + one.unit}"
        for one in shown
    ]
    left = len(fitted) - len(shown)
    others = f"; the other {left} numbers may be nothing." if left else "."
    return [f"{joined_names(numbers)}, as fitted, with 95 % intervals{others}"] if numbers else []


def material_moved(before: Sequence[Interval], after: Sequence[Interval]) -> list[str]:
    """E, nu and mu without effects and with them."""
    said = []
    for old, new in zip(before, after[:3], strict=True):
        scale, unit = _SCALES[old.name]
        pinned = [" (at its bound)" if _is_at_bound(one) else "" for one in (old, new)]
        ends = f"{rounded(new.low * scale, 3)} to {rounded(new.high * scale, 3)}"
        shown = "" if unit == "1" else f" {unit}"
        values = [f"{rounded(one.value * scale, 3)}{note}" for one, note in zip((old, new), pinned, strict=True)]
        said.append(f"{old.name} {values[0]} → {values[1]}{shown} ({ends})")
    return [f"With it, {'; '.join(said)}."]


def material_is_of(settings: Sequence[EffectSetting]) -> list[str]:
    """Of what E, nu and mu are with these effects, where they depend on something."""
    told: dict[str, list[str]] = {}
    for setting in settings:
        values = setting.member.complete(setting.values)
        for name, what in setting.member.material_of(values).items():
            if what not in told.setdefault(name, []):
                told[name].append(what)
    shared = {tuple(what): joined_names([name for name in told if told[name] == what]) for what in told.values()}
    return [
        f"{names} {'are then those' if ' and ' in names else 'is then that'} of {joined_names(what)}."
        for what, names in shared.items()
    ]


def _is_at_bound(one: Interval) -> bool:
    near = NEAR_BOUND * (one.high - one.low)
    return (one.low_is_bound and one.value - one.low <= near) or (one.high_is_bound and one.high - one.value <= near)
