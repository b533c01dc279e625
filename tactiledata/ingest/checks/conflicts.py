"""What recordings contradict in the store that they came to: known only when they are committed."""

from __future__ import annotations

from collections.abc import Collection

from tactiledata.contract.records import Finding
from tactiledata.contract.take import findings_of
from tactiledata.store.read.reader import Store

CONFLICTS = ("sensor-conflict", "signal-variant")


def conflict_findings(store: Store, digests: Collection[str]) -> dict[str, tuple[Finding, ...]]:
    """The conflicts of each of these sources (by SHA-256) with what came before it, each stream's first.

    Values at the moments of frames conflict whenever their signal does, which is said once.
    """
    known = store.manifest["sources"]
    table = store.findings()
    found: dict[str, dict[tuple[str, str], Finding]] = {}
    for source, finding in zip(table["source"].to_pylist(), findings_of(table), strict=True):
        if finding.code in CONFLICTS and known[source] in digests:
            found.setdefault(known[source], {}).setdefault((finding.code, finding.stream), finding)
    return {digest: tuple(findings.values()) for digest, findings in found.items()}
