"""One page of HTML in a single file: sentences first, then tables and pictures; nothing is loaded from elsewhere."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import dataclass, field

from tactiledata.contract.simulated import NOTHING_STATED, SimulatedCount

TEMPLATE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>{{ title }}</title>
<meta name="viewport" content="width=device-width, initial-scale=1">
<style>
:root { color-scheme: light dark; --ink: #1b1f24; --paper: #fff; --grey: #57606a; --line: #d0d7de; --box: #f6f8fa;
  --damage: #b42318; --warning: #9a6700; }
@media (prefers-color-scheme: dark) { :root { --ink: #e6edf3; --paper: #0d1117; --grey: #9198a1; --line: #3d444d;
  --box: #161b22; --damage: #ff7b72; --warning: #d29922; } }
body { font: 16px/1.5 system-ui, sans-serif; max-width: 62rem; margin: 2rem auto; padding: 0 1rem; color: var(--ink);
  background: var(--paper); overflow-wrap: break-word; }
h1 { font-size: 1.6rem; } h2 { font-size: 1.15rem; margin-top: 2rem; border-bottom: 1px solid var(--line); }
summary { font-size: 1.15rem; font-weight: 600; padding: .5rem 0; border-bottom: 1px solid var(--line); cursor: pointer; }
table { border-collapse: collapse; font-size: .9rem; margin: .6rem 0; display: block; overflow-x: auto; }
td, th { padding: .25rem .7rem; border-bottom: 1px solid var(--line); text-align: left; vertical-align: top; }
td.number { text-align: right; font-variant-numeric: tabular-nums; }
img { max-width: 100%; background: #fff; } figure { margin: .6rem 0; }
figcaption { font-size: .85rem; color: var(--grey); }
code, pre { font-family: ui-monospace, monospace; font-size: .85rem; background: var(--box); }
pre { padding: .6rem; overflow-x: auto; } .damage { color: var(--damage); } .warning { color: var(--warning); }
.info { color: var(--grey); }
@media (max-width: 40rem) { figure { overflow-x: auto; } img { max-width: none; width: 48rem; } }
footer { margin-top: 3rem; font-size: .8rem; color: var(--grey); }
</style></head><body>
{% macro shown(picture) %}<figure><img alt="{{ simulated.captioned(picture.caption) }}" src="data:image/png;base64,{{ picture.encoded }}">
<figcaption>{{ simulated.captioned(picture.caption) }}</figcaption></figure>{% endmacro %}
<h1>{{ title }}</h1>
{% if first_picture %}{{ shown(first_picture) }}{% endif %}
{% for sentence in sentences %}<p>{{ sentence }}</p>{% endfor %}
{% for section in sections %}
{% if section.is_folded %}<details><summary>{{ section.title }}</summary>{% else %}<h2>{{ section.title }}</h2>{% endif %}
{% for sentence in section.sentences %}<p{% if sentence.0 %} class="{{ sentence.0 }}"{% endif %}>{{ sentence.1 }}</p>{% endfor %}
{% if section.rows %}<table><tr>{% for name in section.columns %}<th>{{ name }}</th>{% endfor %}</tr>
{% for row in section.rows %}<tr>{% for cell in row %}<td{% if cell is number %} class="number"{% endif %}>{{ cell }}</td>{% endfor %}</tr>
{% endfor %}</table>{% endif %}
{% for picture in section.pictures %}{{ shown(picture) }}{% endfor %}
{% for block in section.code %}<pre>{{ block }}</pre>{% endfor %}
{% if section.is_folded %}</details>{% endif %}
{% endfor %}
<footer>{{ footer }}</footer>
</body></html>
"""


@dataclass(frozen=True)
class Picture:
    """A PNG picture and its caption."""

    png: bytes
    caption: str

    @property
    def encoded(self) -> str:
        """Content of the picture as Base64 text."""
        return base64.b64encode(self.png).decode()


@dataclass(frozen=True)
class Section:
    """A part of a page.

    Parameters
    ----------
    title : str
        Heading.
    sentences : sequence of (kind, text)
        Paragraphs; the kind is ``""``, ``"damage"``, ``"warning"`` or ``"info"`` and decides the colour.
    columns, rows : sequences
        Names of columns and cells of a table; no rows for no table.
    pictures : sequence of Picture
        Pictures below the table.
    code : sequence of str
        Commands or programs to copy.
    is_folded : bool
        Whether only the heading is seen until a reader opens the section.
    """

    title: str
    sentences: Sequence[tuple[str, str]] = ()
    columns: Sequence[str] = ()
    rows: Sequence[Sequence[object]] = ()
    pictures: Sequence[Picture] = field(default_factory=tuple)
    code: Sequence[str] = ()
    is_folded: bool = False


def render_page(
    title: str,
    sentences: Sequence[str],
    sections: Sequence[Section],
    footer: str,
    simulated: SimulatedCount = NOTHING_STATED,
    first_picture: Picture | None = None,
) -> str:
    """Return a page as HTML; all text is escaped.

    Parameters
    ----------
    title : str
        Title and first heading.
    sentences : sequence of str
        Paragraphs before the first section.
    sections : sequence of Section
        Parts of the page.
    footer : str
        Last line.
    simulated : SimulatedCount
        How many of the page's recordings are simulated. Where any is, the title, a last sentence and every caption say
        so.
    first_picture : Picture, optional
        Stands before all sentences.
    """
    from jinja2 import Environment, StrictUndefined

    environment = Environment(autoescape=True, undefined=StrictUndefined)
    return environment.from_string(TEMPLATE).render(
        title=simulated.titled(title),
        sentences=[*sentences, *filter(None, [simulated.sentence])],
        sections=sections,
        footer=footer,
        simulated=simulated,
        first_picture=first_picture,
    )
