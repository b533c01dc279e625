"""The diagnosis of recordings as a page to read: sentences first, then where, what, how, and how much better."""

from __future__ import annotations

import math
from collections.abc import Sequence

from tactiledata.contract.simulated import NOTHING_STATED, SimulatedCount
from tactiledata.diagnose.answer.locator_rows import locators_section, shares_section
from tactiledata.diagnose.answer.sentences import Answer
from tactiledata.diagnose.answer.unseen_page import better_section, comparison_sections, doubts, shown_sentences
from tactiledata.diagnose.locate.locate import LocatorResults
from tactiledata.diagnose.naming.evidence import ScoredCandidate
from tactiledata.diagnose.naming.intervals import ProfiledInterval
from tactiledata.diagnose.naming.name_effects import NamingResult
from tactiledata.diagnose.naming.thresholds import DEFAULT_THRESHOLDS
from tactiledata.diagnose.residuals.wording import percent, rounded, with_interval
from tactiledata.diagnose.unseen.compare import HeldOutComparison
from tactiledata.effects import EFFECTS
from tactiledata.report.naming_plots import Moved, draw_ladder, draw_movement
from tactiledata.report.page import Picture, Section, render_page
from tactiledata.report.plots import png_bytes

MOST_FIRST = 3
"""Sentences of the locators that stand at the top, and findings of each in their section."""
MOST_CANDIDATES = 12
LEAST_PROBABILITY = 0.005
OTHERS = {"none": "nothing", "other": "something outside the catalogue"}


def naming_page(
    title: str,
    naming: NamingResult,
    located: LocatorResults,
    shown: HeldOutComparison,
    trials: Sequence[tuple[str, str]] = (),
    notes: Sequence[str] = (),
    footer: str = "",
    further: Sequence[str] = (),
    first: Sequence[str] = (),
    simulated: SimulatedCount = NOTHING_STATED,
) -> str:
    """The page as HTML.

    Parameters
    ----------
    located : LocatorResults
        Of the plain simulation.
    trials : sequence of (words, file)
        What to record next.
    notes : what was left out
    further, first : sentences that follow those of `naming_sentences`, and that go before them
    simulated : SimulatedCount
        Of the trajectories that were diagnosed.
    """
    answer = Answer(naming)
    sentences = [*first, *naming_sentences(naming, located, shown), *further]
    shares = shares_section(located) if located.is_structured else None
    sections = [
        locators_section(located, MOST_FIRST),
        *([shares] if shares is not None else []),
        _what(naming),
        _how(naming, bool(answer.names)),
        better_section(shown),
        *comparison_sections(naming, located, shown, simulated.heading),
        *_seen_at_all(naming),
    ]
    if trials:
        sections.append(Section("What to record next", columns=("trial", "file"), rows=list(trials)))
    if notes:
        sections.append(Section("What was left out", [("warning", note) for note in notes]))
    return render_page(title, sentences, sections, footer, simulated)


def naming_sentences(naming: NamingResult, located: LocatorResults, shown: HeldOutComparison) -> list[str]:
    """What is missing, where it shows, how the simulation behaves with it, and how much better it then fits."""
    answer = Answer(naming)
    where = located.sentences()[:MOST_FIRST]
    if located.is_structured and not answer.is_missing:
        where.insert(
            0, "Some structure stands out all the same, less than any effect that could be claimed would make:"
        )
    parts = {"Where": where, "How": answer.how, "How much better": shown_sentences(shown)}
    claim, *more = answer.what
    return [
        claim,
        *doubts(shown),
        *more,
        *(sentence for title, said in parts.items() for sentence in _titled(title, said)),
    ]


def _titled(title: str, said: Sequence[str]) -> list[str]:
    return [f"{title}: {said[0]}", *said[1:]] if said else []


def title_of(names: Sequence[str]) -> str:
    """Titles of effects, as ``"arm compliance + time lag"``."""
    return " + ".join(EFFECTS[name]().title for name in names)


def _what(naming: NamingResult) -> Section:
    ranked = sorted(naming.scored, key=lambda one: -one.evidence)[:MOST_CANDIDATES]
    if not ranked:
        return Section("What is missing", [("", "No effect of the catalogue promises anything: none was refitted.")])
    text = (
        "Evidence is the logarithm of the Bayes factor against the plain simulation (what is left without the two "
        "trajectories that bring most). Gains are those of the log-likelihood where a candidate was not fitted, with "
        "their standard errors; agreement is that of trajectories before and after, in standard errors. Simulators "
        "that differ bring evidence, too: probabilities follow it on a scale that was fitted to worlds of known truth, "
        "far more slowly than a Bayes factor would have it."
    )
    said = [("info", text), ("info", _probabilities(naming))]
    columns = ("candidate", "evidence", "gain", "gain on indenters", "agreement", "objections")
    drawn = draw_ladder(
        [title_of(one.names) for one in ranked], [one.gain for one in ranked], [one.gain_error for one in ranked],
        DEFAULT_THRESHOLDS.claim_gain,
    )  # fmt: skip
    picture = Picture(png_bytes(drawn), "Candidates on trajectories that were held out; bars are two standard errors.")
    return Section("What is missing", said, columns, [_candidate(one) for one in ranked], [picture])


def _candidate(one: ScoredCandidate) -> tuple[str, ...]:
    alone = one.indenter_gain != one.indenter_gain
    return (
        title_of(one.names),
        _unbroken(f"{one.evidence:.0f} ({one.evidence_without_best_two:.0f})"),
        _unbroken(with_interval(one.gain, one.gain_error, "1")),
        "-" if alone else _unbroken(with_interval(one.indenter_gain, one.indenter_error, "1")),
        _unbroken(f"{one.signature_before:.1f} → {one.signature_after:.1f}"),
        "; ".join(one.objections(DEFAULT_THRESHOLDS)) or "none",
    )


def _unbroken(text: str) -> str:
    return text.replace(" ", "\N{NO-BREAK SPACE}")


def _probabilities(naming: NamingResult) -> str:
    chances = sorted(naming.decision.probabilities.items(), key=lambda one: -one[1])
    listed = [
        f"{OTHERS.get(label) or title_of(label.split(' + '))} {percent(chance)}"
        for label, chance in chances
        if chance >= LEAST_PROBABILITY
    ]
    return f"Probabilities: {', '.join(listed)}."


def _how(naming: NamingResult, is_claimed: bool) -> Section:
    before, after = naming.intervals_before, naming.intervals if is_claimed else ()
    rows = []
    for place, one in enumerate(after or before):
        plain = _said(before[place]) if place < len(before) else ("-", "-")
        rows.append((_with_unit(one), *plain, *(_said(one) if is_claimed else ())))
    columns = ("", "plain", "95 % interval", *(("with it", "95 % interval") if is_claimed else ()))
    moved = [
        Moved(_with_unit(old), _ends(old), _ends(after[place]) if is_claimed else None)
        for place, old in enumerate(before)
    ]
    caption = "E, nu and mu of the plain simulation, and with the effect; bars are 95 % intervals."
    picture = Picture(png_bytes(draw_movement(moved)), caption if is_claimed else "Bars are 95 % intervals.")
    return Section("How the simulation behaves", (), columns, rows, [picture])


def _scale(one: ProfiledInterval) -> float:
    return 1e-3 if one.unit == "Pa" else 1.0


def _with_unit(one: ProfiledInterval) -> str:
    unit = {"Pa": "kPa", "1": ""}.get(one.unit, one.unit)
    name = one.name.replace("_", " ")
    return f"{name}, {unit}" if unit else name


def _ends(one: ProfiledInterval) -> tuple[float, float, float]:
    return one.low * _scale(one), one.value * _scale(one), one.high * _scale(one)


def _said(one: ProfiledInterval) -> tuple[str, str]:
    ends = _ends(one)
    half = (ends[2] - ends[0]) / 2
    places = min(max(0, 1 - math.floor(math.log10(half))), 6) if half > 0 else 3
    low, value, high = (f"{end:.{places}f}" for end in ends)
    pinned = [" (bound)" if is_bound else "" for is_bound in (one.low_is_bound, one.high_is_bound)]
    return value, f"{low}{pinned[0]} to {high}{pinned[1]}"


def _seen_at_all(naming: NamingResult) -> list[Section]:
    """What these trajectories could tell, whatever the measured forces are."""
    known = naming.identifiable
    order = sorted(range(len(known.effects)), key=lambda place: -known.reach[place])
    most = {known.effects[place]: place for place in reversed(order)}
    rows = [
        (
            EFFECTS[known.effects[place]]().title,
            known.strengths[place].replace("_", " "),
            percent(known.concealment[place]),
            rounded(float(known.reach[place])),
        )
        for place in order
        if most[known.effects[place]] == place
    ]
    text = (
        "The number of each effect that can be seen best. What it changes, and E, nu, mu, offsets and errors of the "
        "simulation imitate, is hidden. Reach is the signal over noise of what is left, at the end of the plausible "
        f"range; from {rounded(DEFAULT_THRESHOLDS.visible)} on it can be claimed."
    )
    said = [("info", text)]
    if known.undetectable:
        said.append(("", f"Could be there and not show: {', '.join(title_of([name]) for name in known.undetectable)}."))
    if naming.not_tried:
        names = ", ".join(title_of([name]) for name in naming.not_tried)
        said.append(("", f"Not asked, as the recordings do not tell what they depend on: {names}."))
    sections = [Section("What could be seen at all", said, ("effect", "number", "hidden", "reach"), rows)]
    alike = [(title_of([first]), title_of([second]), rounded(size)) for first, second, size in known.look_alikes()]
    if alike:
        text = "Their traces, beyond what is hidden, have a cosine of at least 0.95 in these trajectories."
        sections.append(Section("Look-alikes", [("info", text)], ("effect", "effect", "cosine"), alike))
    return sections
