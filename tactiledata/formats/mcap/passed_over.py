"""Topics that could be a stream which a recording otherwise lacks, and are not read: said by name, not passed over."""

from __future__ import annotations

from collections.abc import Container, Iterable

from tactiledata.contract.records import Finding
from tactiledata.contract.wording import agreeing, counted, listed
from tactiledata.formats.mcap.roles import IMAGE_KINDS, KINDS_OF_SIGNAL, TF_KIND, Roles, Topic

STREAMS = {
    "wrench": tuple(KINDS_OF_SIGNAL["wrench"]),
    "tcp": tuple(kind for kind in KINDS_OF_SIGNAL["tcp"] if kind != TF_KIND),
    "images": IMAGE_KINDS,
}
"""Types of message that are a whole stream; a tree of transforms holds many poses and may hold none of the tool."""
TOPIC_LEFT = "topic-left"
"""Code of the finding on a stream that is missing though topics could be it."""
MOST_NAMES = 4


def passed_over(
    topics: Iterable[Topic], roles: Roles, n_messages: dict[str, int], stated: Container[str]
) -> list[Finding]:
    """What topics hold and nobody reads: a finding for all that are left, and one for each stream that is missing.

    A stream is missing where no topic is read as it, although topics of its type hold messages.

    Parameters
    ----------
    topics : iterable of Topic
    roles : Roles
        What is read.
    n_messages : dict of topic to int
        Messages of each topic as the file counts them; a topic that is not in it may hold some.
    stated : container of str
        Streams that a mapping names: what of them is not there is said already.
    """
    read = {role.name for role in roles.signals} | ({"images"} if roles.images else set())
    known = list(topics)
    left = [topic for topic in known if topic.name not in roles.topics and n_messages.get(topic.name, 1)]
    found = [_not_read(left, len(known))] if left else []
    for stream, kinds in STREAMS.items():
        names = sorted(topic.name for topic in left if topic.kind in kinds)
        if stream in read or stream in stated or not names:
            continue
        first = listed(names, MOST_NAMES)
        why = "its name says" if len(names) == 1 else "their names say"
        text = (
            f"nothing is read as {stream}, and {first} could be it: {why} too little. Name the topic in a mapping: "
            "`tactiledata inspect PATH --suggest-mapping` writes one to start from"
        )
        found.append(Finding(TOPIC_LEFT, "warning", text, stream, count=len(names)))
    return found


def _not_read(left: list[Topic], n_topics: int) -> Finding:
    """Say which topics stay behind, and how to read them."""
    names = sorted({topic.name for topic in left})
    are = agreeing(len(names), "is", "are")
    text = (
        f"{len(names)} of {counted(n_topics, 'topic')} {are} not read: {listed(names, MOST_NAMES)}. "
        "`tactiledata inspect PATH --suggest-mapping` writes a mapping with the lines that read each"
    )
    return Finding("topics-not-read", "info", text, count=len(names))
