"""Whether the sealed cases tell what they hide by anything but their readings: names, sizes, stamps and order.

A decision tree learns the kind of a case from these facts, and is tried on cases that it has not seen. The same with
permuted kinds says how often chance does as well.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from tactiledata.arrays import Array
from tactiledata.contract.extras import missing_package
from tactiledata.errors import UsageError
from tactiledata.prove.seal.folder import ProofFolder, read_json, read_readings

FOLDS = 5
"""Number of folds; the tree is tried on each after it learned from the others."""
REPEATS = 3
"""Number of ways in which cases are dealt to folds."""
DEPTH = 3
"""Depth of the tree: a plain leak needs one question."""
FEWEST = 10
"""Fewest cases from which anything is said."""


@dataclass(frozen=True)
class Leak:
    """How well a classifier tells kinds of cases from facts that should tell nothing.

    Parameters
    ----------
    accuracy : float
        Share of cases whose kind it tells, each kind with the same weight.
    by_chance : float
        Median of the same with permuted kinds.
    p : float
        Share of permutations that do at least as well.
    cases : int
        Number of cases.
    """

    accuracy: float
    by_chance: float
    p: float
    cases: int

    @property
    def sentence(self) -> str:
        """The finding in a sentence."""
        return (
            f"A classifier that sees names, sizes, stamps and order of the {self.cases} cases tells their kinds with an"
            f" accuracy of {self.accuracy:.2f}; with permuted kinds it is {self.by_chance:.2f} (p = {self.p:.2f})."
        )


def case_facts(folder: ProofFolder, names: list[str], plans: Mapping[str, str]) -> Array:
    """Return what can be known of cases (n, f) without their readings' values.

    Parameters
    ----------
    folder : ProofFolder
        The folder of the proof.
    names : list of str
        Names of the cases, in the order of the seal.
    plans : dict, name -> plan
        Plans of the cases.
    """
    listed = sorted(set(plans.values()))
    rows = []
    for place, name in enumerate(names):
        path = folder.case(name)
        facts = path.stat()
        counts = [len(t_ns) for t_ns, _ in read_readings(path)]
        digits = [int(digit, 16) if digit in "0123456789abcdef" else -1 for digit in name[:16].ljust(16, "0")]
        stamps = [facts.st_mtime_ns % 10**15 / 1e6, facts.st_mode]
        rows.append([place, listed.index(plans[name]), facts.st_size, *stamps, len(counts), sum(counts), *digits])
    return np.array(rows, dtype=float)


def find_leak(facts: Array, kinds: list[str], draws: int = 99, seed: int = 0) -> Leak:
    """Return how well kinds of cases are told from facts.

    Parameters
    ----------
    facts : (n, f)
        Facts of the cases.
    kinds : list of str
        Kinds of the cases.
    draws : int
        Number of permutations.
    seed : int
        Seed of folds, permutations and tree.

    Raises
    ------
    UsageError
        scikit-learn is not installed, or there are fewer than ``FEWEST`` cases.
    """
    try:
        from sklearn.tree import DecisionTreeClassifier
    except ImportError as error:
        raise missing_package("sklearn", "a search for leaks") from error
    if len(kinds) < FEWEST:
        raise UsageError(f"{len(kinds)} cases", f"at least {FEWEST}, to look for leaks", "Draw more cases.")
    chance = np.random.default_rng(seed)
    # several ways to deal cases to folds: with few cases a single one is luck
    dealt = [chance.permutation(len(kinds)) % FOLDS for _ in range(REPEATS)]
    classes, target = np.unique(kinds, return_inverse=True)

    def accuracy(labels: Any) -> float:
        right = np.zeros(len(labels))
        for folds in dealt:
            for fold in range(FOLDS):
                tree = DecisionTreeClassifier(max_depth=DEPTH, class_weight="balanced", random_state=seed)
                tree.fit(facts[folds != fold], labels[folds != fold])
                right[folds == fold] += (tree.predict(facts[folds == fold]) == labels[folds == fold]) / REPEATS
        return float(np.mean([right[labels == each].mean() for each in range(len(classes))]))

    found = accuracy(target)
    permuted = [accuracy(chance.permutation(target)) for _ in range(draws)]
    p = (1 + sum(one >= found for one in permuted)) / (1 + draws)
    return Leak(found, float(np.median(permuted)), p, len(kinds))


def leak_of(folder: ProofFolder, draws: int = 99) -> Leak:
    """Return how well the kinds of a proof's cases are told from names, sizes, stamps and order.

    Parameters
    ----------
    folder : ProofFolder
        The folder of the proof.
    draws : int
        Number of permutations.
    """
    seal, labels = read_json(folder.seal), read_json(folder.labels)
    names = list(seal["cases"])
    plans = {name: one["plan"] for name, one in seal["cases"].items()}
    return find_leak(case_facts(folder, names, plans), [labels[name]["label"]["kind"] for name in names], draws)
