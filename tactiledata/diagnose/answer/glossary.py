"""Explanations of the terms of a diagnosis, each placed on a page after the sentence in which the term first stands."""

from __future__ import annotations

import re
from collections.abc import Sequence

Terms = tuple[tuple[str, str], ...]

FIRST = 3
"""Sentences at the top of a page between which no explanation stands: they are the answer."""
TERMS: Terms = (
    (r"\bof random halves\b", "Halves: a term is kept if most of a hundred random halves of the groups choose it."),
    (r"\b[Ss]tructure", "Structure: differences that depend on something, and do not only vary by chance."),
    (r"\b[Ll]ocator", "A locator is a test that asks where predictions and measurements differ."),
    (r"\bp (=|<) ", "p is the probability of a result at least as strong where nothing is missing."),
    (r"\btimes the noise\b", "The noise is the standard deviation of one measurement."),
    (
        r"\balso explained by\b",
        "Also explained by: these covariates vary together with the one that is named. These data cannot tell which of"
        " them is the cause.",
    ),
    (
        r"\bheld-out (trajectories|indenters|sensors)\b",
        "Held out: these took no part in the fit. Their errors show what is predicted, not what is memorised.",
    ),
    (
        r"\bgap\b",
        "The gap is the error before, less the noise floor: the error that noise leaves to a perfect simulation.",
    ),
    (
        r"\b[Bb]lack box\b",
        "A black box predicts without physics. It shows how much of the error any model could remove.",
    ),
)
"""Pattern of each term that pages of stores and tables share, and its explanation."""
STORE_TERMS: Terms = (
    (
        r"\(probability ",
        "Probability: how often the named effect was missing, alone or with another one, where claims had as much "
        "evidence in simulated worlds of known truth.",
    ),
    (
        r"\b(E|[Nn]u|[Mm]u)\b",
        "E is the stiffness of the gel (Young's modulus), nu its Poisson's ratio and mu its friction.",
    ),
    (r"\bcosine\b", "A cosine of 1 means that two effects change the wrench in the same way."),
    (
        r"\bheld-out gains?\b",
        "Held-out gain: the rise of the log-likelihood of trajectories that had no part in the fit.",
    ),
    *TERMS,
)
"""Pattern of each term of a store's page, and its explanation."""


def with_explanations(sentences: Sequence[str], terms: Terms = TERMS) -> list[tuple[str, str]]:
    """Return sentences as paragraphs of a page, each followed by explanations of the terms that it uses first.

    A paragraph is a kind and a text: ``""`` for a sentence, ``"info"`` for an explanation. Terms of the first `FIRST`
    sentences are explained after these.
    """
    explained: list[tuple[str, str]] = []
    waiting: list[str] = []
    unexplained = dict(terms)
    for number, sentence in enumerate(sentences, start=1):
        explained.append(("", sentence))
        used = [pattern for pattern in unexplained if re.search(pattern, sentence)]
        waiting += [unexplained.pop(pattern) for pattern in used]
        if number >= min(FIRST, len(sentences)):
            explained += [("info", words) for words in waiting]
            waiting = []
    return explained
