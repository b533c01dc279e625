"""The page of a store's diagnosis: a picture, three sentences, what to record next; all else folds away below."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from tactiledata.contract.simulated import NOTHING_STATED, SimulatedCount
from tactiledata.diagnose.answer.glossary import STORE_TERMS, with_explanations
from tactiledata.diagnose.answer.locator_rows import locators_section, shares_section
from tactiledata.diagnose.answer.sentences import MOST_PROBABLE, Answer
from tactiledata.diagnose.answer.unseen_page import (
    WITH_EFFECT,
    better_section,
    comparison_sections,
    doubts,
    shown_sentences,
    worst_picture,
)
from tactiledata.diagnose.locate.locate import LocatorResults
from tactiledata.diagnose.naming.beside import objections_to
from tactiledata.diagnose.naming.decide import BESIDE, NONE, OTHER
from tactiledata.diagnose.naming.evidence import ScoredCandidate
from tactiledata.diagnose.naming.intervals import ProfiledInterval
from tactiledata.diagnose.naming.name_effects import NamingResult
from tactiledata.diagnose.naming.thresholds import DecisionThresholds
from tactiledata.diagnose.residuals.wording import percent, rounded, with_interval
from tactiledata.diagnose.unseen.compare import HeldOutComparison
from tactiledata.effects import EFFECTS
from tactiledata.report.naming_plots import Moved, draw_ladder, draw_movement
from tactiledata.report.page import Section, render_page
from tactiledata.report.panels import panels_of

MOST_FIRST = 3
"""Most sentences of the locators at the top, and most findings of each locator in its section."""
MOST_CANDIDATES = 12
"""Most candidates in the table."""
LEAST_PROBABILITY = 0.005
"""Smallest probability that is listed."""
OTHERS = {
    BESIDE: "one of these and another effect beside it",
    NONE: "nothing",
    OTHER: "something outside the catalogue",
}
"""Names of the probabilities that belong to no candidate."""


def naming_page(
    title: str,
    naming: NamingResult,
    located: LocatorResults,
    shown: HeldOutComparison,
    trials: Sequence[tuple[str, str]] = (),
    notes: Sequence[str] = (),
    footer: str = "",
    *,
    further: Sequence[str] = (),
    first: Sequence[str] = (),
    other_steps: Section | None = None,
    simulated: SimulatedCount = NOTHING_STATED,
) -> str:
    """Return the page of a diagnosis as HTML.

    It begins with a picture of the mismatch and its cure, with the answer in three sentences, and with what to record
    next. All sentences and the sections are folded below.

    Parameters
    ----------
    title : str
    naming : NamingResult
    located : LocatorResults
        Results of the locators on the plain simulation.
    shown : HeldOutComparison
        Errors on held-out data.
    trials : sequence of (title, file)
        What to record next.
    notes : sequence of str
        What was left out, and why.
    footer : str
    further, first : sequence of str
        Sentences after those of `naming_sentences`, and before them.
    other_steps : Section, optional
        How E, nu and mu relate to those of other steps.
    simulated : SimulatedCount
        How many of the trajectories are of simulated recordings.
    """
    answer = Answer(naming)
    sentences = [*first, *naming_sentences(naming, located, shown), *further]
    shares = shares_section(located) if located.is_structured else None
    details = [
        Section("All in words", with_explanations(sentences, STORE_TERMS)),
        locators_section(located, MOST_FIRST),
        *([shares] if shares is not None else []),
        _what(naming),
        _how(naming, bool(answer.names)),
        *([other_steps] if other_steps is not None else []),
        better_section(shown),
        *comparison_sections(naming, located, shown),
        *_seen_at_all(naming),
    ]
    if notes:
        details.append(Section("What was left out", [("warning", note) for note in notes]))
    sections = [replace(section, is_folded=True) for section in details]
    if trials:
        sections.insert(0, Section("What to record next", columns=("trial", "file"), rows=list(trials)))
    # what is missing comes first; where nothing is named, what the readings show by themselves does
    claim, *others = _in_short(answer, shown)
    beginning = [claim, *first, *others] if answer.names else [*first, claim, *others]
    paragraphs = with_explanations(beginning, STORE_TERMS)
    return render_page(title, paragraphs, sections, footer, simulated, worst_picture(naming, shown))


def _in_short(answer: Answer, shown: HeldOutComparison) -> list[str]:
    """Return three sentences: the answer, what should be known with it, and how much better the simulation is."""
    claim, *more = answer.what
    beside = [*doubts(shown), *more]
    return [claim, *beside[:1], shown_sentences(shown)[0]]


def naming_sentences(naming: NamingResult, located: LocatorResults, shown: HeldOutComparison) -> list[str]:
    """Return sentences on what is missing, where it shows, how the simulation behaves with it, and how much it helps.

    Parameters
    ----------
    naming : NamingResult
    located : LocatorResults
        Results of the locators on the plain simulation.
    shown : HeldOutComparison
        Errors on held-out data.
    """
    answer = Answer(naming)
    where = located.sentences()[:MOST_FIRST]
    if located.is_structured and not answer.is_missing:
        where.insert(0, "Locators find structure all the same; it is weaker than any effect that could be claimed:")
    parts = {"Where": where, "How": answer.how, "How much better": shown_sentences(shown)}
    claim, *more = answer.what
    return [
        claim,
        *doubts(shown),
        *more,
        *(sentence for title, sentences in parts.items() for sentence in _titled(title, sentences)),
    ]


def _titled(title: str, sentences: Sequence[str]) -> list[str]:
    """Return sentences, the first one after a title and a colon."""
    return [f"{title}: {sentences[0]}", *sentences[1:]] if sentences else []


def title_of(names: Sequence[str]) -> str:
    """Return the titles of effects, as ``"arm compliance + time lag"``."""
    return " + ".join(EFFECTS[name]().title for name in names)


def _what(naming: NamingResult) -> Section:
    """Return the section with the candidates, those with most evidence first, and their probabilities."""
    ranked = sorted(naming.scored, key=lambda candidate: -candidate.evidence)[:MOST_CANDIDATES]
    if not ranked:
        return Section("What is missing", [("", "No effect of the catalogue looks promising: none was refitted.")])
    text = (
        "Evidence is the logarithm of the Bayes factor against the plain simulation: how much more likely the data are "
        "with the candidate. In brackets: without the two trajectories that bring most of it. A claim needs more of it "
        "where errors of a simulation resemble the effect. Gain is the rise of the "
        "log-likelihood on held-out trajectories, gain on indenters that on held-out indenters, each with its standard "
        "error. Agreement is how clearly trajectories agree on the candidate before and after the refit, in standard "
        "errors. An objection says why a candidate is not claimed."
    )
    scale = (
        "Probabilities follow the evidence beyond what a claim needs. They grow far more slowly than a Bayes factor, "
        "as differences between two simulators bring evidence as well. However large it is, a part is kept for another "
        "effect beside the named one, and for what the catalogue does not have and would look alike."
    )
    sentences = [("info", text), ("info", scale), ("info", _probabilities(naming))]
    columns = ("candidate", "evidence", "gain", "gain on indenters", "agreement", "objections")
    drawn = draw_ladder(
        [title_of(candidate.names) for candidate in ranked],
        [candidate.evidence for candidate in ranked],
        [candidate.needed(naming.thresholds) for candidate in ranked],
    )
    caption = "Evidence of the candidates, and the evidence that a claim of each needs."
    picture = panels_of(drawn, caption)
    singles = [one for one in naming.scored if len(one.names) == 1]
    rows = [_cells(candidate, singles, naming.thresholds) for candidate in ranked]
    return Section("What is missing", sentences, columns, rows, [picture])


def _cells(
    candidate: ScoredCandidate, singles: Sequence[ScoredCandidate], thresholds: DecisionThresholds
) -> tuple[str, ...]:
    """Return the cells of a candidate's row; ``singles`` are the candidates with one effect."""
    # NaN where there is one indenter only: nothing could be held out
    is_alone = candidate.indenter_gain != candidate.indenter_gain
    return (
        title_of(candidate.names),
        _unbroken(f"{candidate.evidence:.0f} ({candidate.evidence_without_best_two:.0f})"),
        _unbroken(with_interval(candidate.gain, candidate.gain_error, "1")),
        "-" if is_alone else _unbroken(with_interval(candidate.indenter_gain, candidate.indenter_error, "1")),
        _unbroken(f"{candidate.signature_before:.1f} → {candidate.signature_after:.1f}"),
        "; ".join(objections_to(candidate, singles, thresholds)) or "none",
    )


def _unbroken(text: str) -> str:
    """Return a text that stays on one line."""
    return text.replace(" ", "\N{NO-BREAK SPACE}")


def _probabilities(naming: NamingResult) -> str:
    """Return a sentence with the probabilities of all candidates, of nothing and of something else, largest first.

    No probability above `MOST_PROBABLE` is stated, as in the claim.
    """
    ranked = sorted(naming.decision.probabilities.items(), key=lambda item: -item[1])
    listed = [
        f"{OTHERS.get(label) or title_of(label.split(' + '))} {percent(min(probability, MOST_PROBABLE))}"
        for label, probability in ranked
        if probability >= LEAST_PROBABILITY
    ]
    return f"Probabilities: {', '.join(listed)}."


def _how(naming: NamingResult, is_claimed: bool) -> Section:
    """Return the section with E, nu, mu and the effects' numbers, plain and with the claimed effect."""
    # rows of the table
    before, after = naming.intervals_before, naming.intervals if is_claimed else ()
    rows = []
    for place, number in enumerate(after or before):
        plain = _value_and_interval(before[place]) if place < len(before) else ("-", "-")
        rows.append((_with_unit(number), *plain, *(_value_and_interval(number) if is_claimed else ())))
    columns = ("", "plain", "95 % interval", *((WITH_EFFECT, "95 % interval") if is_claimed else ()))
    # the picture
    moved = [
        Moved(_with_unit(old), _ends(old), _ends(after[place]) if is_claimed else None)
        for place, old in enumerate(before)
    ]
    caption = (
        f"E, nu and mu of the plain simulation{' and with the effect' if is_claimed else ''}; bars are 95 % intervals."
    )
    picture = panels_of(draw_movement(moved), caption)
    return Section("How the simulation behaves", (), columns, rows, [picture])


def _scale(number: ProfiledInterval) -> float:
    """Return the factor from SI to the unit on the page: kPa for Pa."""
    return 1e-3 if number.unit == "Pa" else 1.0


def _with_unit(number: ProfiledInterval) -> str:
    """Return the name of a number with its unit on the page."""
    unit = {"Pa": "kPa", "1": ""}.get(number.unit, number.unit)
    name = number.name.replace("_", " ")
    return f"{name}, {unit}" if unit else name


def _ends(number: ProfiledInterval) -> tuple[float, float, float]:
    """Return low end, value and high end of a number in its unit on the page."""
    return number.low * _scale(number), number.value * _scale(number), number.high * _scale(number)


def _value_and_interval(number: ProfiledInterval) -> tuple[str, str]:
    """Return value and interval as texts, with the digits that the interval allows; an end at a bound says so."""
    ends = _ends(number)
    half = (ends[2] - ends[0]) / 2
    places = min(max(0, 1 - math.floor(math.log10(half))), 6) if half > 0 else 3
    low, value, high = (f"{end:.{places}f}" for end in ends)
    pinned = [" (bound)" if is_bound else "" for is_bound in (number.low_is_bound, number.high_is_bound)]
    return value, f"{low}{pinned[0]} to {high}{pinned[1]}"


def _seen_at_all(naming: NamingResult) -> list[Section]:
    """Return the sections on what these trajectories can show at all, whatever the measured forces are."""
    # the number of each effect that could be seen best
    known = naming.identifiable
    order = sorted(range(len(known.effects)), key=lambda place: -known.reach[place])
    most = {known.effects[place]: place for place in reversed(order)}
    rows = [
        (
            EFFECTS[known.effects[place]]().title,
            known.strengths[place].replace("_", " "),
            percent(known.concealment[place]),
            rounded(float(known.reach[place])),
            rounded(float(known.visible[place])),
        )
        for place in order
        if most[known.effects[place]] == place
    ]
    text = (
        "Each row is the number of an effect that these recordings show best. Concealed is the share of its change "
        "that E, nu, mu, offsets and errors of the simulation can imitate. Reach is the ratio of signal to noise of "
        "the rest, at the end of the plausible range. Needed is the reach from which the effect can be claimed."
    )
    sentences = [("info", text)]
    if known.undetectable:
        names = ", ".join(title_of([name]) for name in known.undetectable)
        sentences.append(("", f"Not detectable in these recordings: {names}."))
    if naming.not_tried:
        names = ", ".join(title_of([name]) for name in naming.not_tried)
        sentences.append(("", f"Not tried, as the recordings do not state what these effects depend on: {names}."))
    sections = [
        Section("What could be seen at all", sentences, ("effect", "number", "concealed", "reach", "needed"), rows)
    ]
    # pairs that these trajectories cannot tell apart
    alike = [(title_of([first]), title_of([second]), rounded(size)) for first, second, size in known.look_alikes()]
    if alike:
        text = (
            "Beyond what is concealed, the two effects of a row change the wrench almost alike (cosine of at least"
            " 0.95): these trajectories cannot tell them apart."
        )
        sections.append(Section("Look-alikes", [("info", text)], ("effect", "effect", "cosine"), alike))
    return sections
