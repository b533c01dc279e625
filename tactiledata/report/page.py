"""One page of HTML in a single file: sentences first, then tables and pictures; nothing is loaded from elsewhere.

All pages share this look. In every picture measured values are dots and simulated values are lines
(`tactiledata.report.marks`).
"""

from __future__ import annotations

import base64
import re
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING

from tactiledata.contract.simulated import NOTHING_STATED, SimulatedCount

if TYPE_CHECKING:
    from markupsafe import Markup

CODE = re.compile(r"`([^`\n]+)`")
"""What a sentence quotes of a command or a program."""
WORD = re.compile(r"\[([a-z0-9-]+)\]")
"""What may be a word of a page's glossary."""
PROSE = 60
"""Letters of a cell from which it is a sentence: its column is not squeezed to a few letters on a phone."""
TEMPLATE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>{{ title }}</title>
<meta name="viewport" content="width=device-width, initial-scale=1"><link rel="icon" href="data:,">
<meta name="generator" content="tactiledata">
<style>
:root { color-scheme: light dark; --ink: #1b1f24; --paper: #fff; --grey: #57606a; --line: #d0d7de; --box: #f6f8fa;
  --link: #0a58ca; --damage: #b42318; --warning: #8a5a00; }
@media (prefers-color-scheme: dark) { :root { --ink: #e6edf3; --paper: #0d1117; --grey: #9198a1; --line: #3d444d;
  --box: #161b22; --link: #79b8ff; --damage: #ff7b72; --warning: #d9a441; }
  .drawn { filter: invert(1) hue-rotate(180deg); } }
body { font: 16px/1.5 system-ui, sans-serif; max-width: 62rem; margin: 2rem auto; padding: 0 1rem; color: var(--ink);
  background: var(--paper); overflow-wrap: break-word; }
a { color: var(--link); } p { max-width: 48rem; margin: .6rem 0; }
:focus-visible { outline: 3px solid var(--link); outline-offset: 2px; }
.skip { position: absolute; left: -99rem; } .skip:focus { left: 1rem; top: .5rem; }
h1 { font-size: 1.6rem; line-height: 1.25; } h2 { font-size: 1.15rem; margin: 2rem 0 .6rem; border-bottom: 1px solid var(--line); }
nav ul, .legend { list-style: none; padding: 0; margin: .6rem 0; display: flex; flex-wrap: wrap; gap: .2rem 1.2rem; }
nav a { display: inline-block; padding: .2rem 0; }
summary { padding: .5rem 0; border-bottom: 1px solid var(--line); cursor: pointer; }
summary h2 { display: inline; border: 0; }
.scroll { overflow-x: auto; margin: .6rem 0; /* a shade at an edge beyond which there is more of a table */
  background: linear-gradient(to right, var(--paper) 30%, transparent) left/2rem 100% no-repeat local,
  linear-gradient(to left, var(--paper) 30%, transparent) right/2rem 100% no-repeat local,
  linear-gradient(to right, var(--grey), transparent) left/.5rem 100% no-repeat scroll,
  linear-gradient(to left, var(--grey), transparent) right/.5rem 100% no-repeat scroll; } table { border-collapse: collapse; font-size: .9rem; }
td, th { padding: .25rem .7rem; border-bottom: 1px solid var(--line); text-align: left; vertical-align: top; }
th { white-space: nowrap; } td.prose { min-width: min(22rem, 70vw); } td.number { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; }
figure { margin: .8rem 0 1.2rem; } figcaption, .legend { font-size: .85rem; color: var(--grey); }
figcaption { max-width: 48rem; } .legend svg { vertical-align: -.1em; margin-right: .4em; }
.row { display: flex; flex-wrap: wrap; align-items: flex-start; } .row img { display: block; height: auto; box-sizing: border-box; }
code, pre { font-family: ui-monospace, monospace; font-size: .85rem; background: var(--box); }
pre { padding: .6rem; overflow-x: auto; } .damage { color: var(--damage); } .warning { color: var(--warning); }
.info { color: var(--grey); }
footer { margin-top: 3rem; font-size: .8rem; color: var(--grey); overflow-wrap: anywhere; }
@media (max-width: 40rem) { td { min-width: 4.5rem; } td:first-child { min-width: 7rem; } td, th { padding: .25rem .45rem; } }
</style></head><body>
{% macro mark(entry) %}<svg class="drawn" width="26" height="12" aria-hidden="true" fill="{{ entry.colour }}" stroke="{{ entry.colour }}">
{%- if entry.mark == "dot" %}<circle cx="13" cy="6" r="3" stroke="none"/>
{%- elif entry.mark == "line" %}<path d="M1 6H25" stroke-width="2"/>
{%- elif entry.mark == "dashes" %}<path d="M1 6H25" stroke-width="2" stroke-dasharray="6 3"/>
{%- elif entry.mark == "tick" %}<path d="M13 1V11" stroke-width="2"/>
{%- elif entry.mark == "cross" %}<path d="M10 3L16 9M16 3L10 9" stroke-width="1.5"/>
{%- elif entry.mark == "square" %}<rect x="10" y="3" width="6" height="6" stroke="none"/>
{%- elif entry.mark == "joined squares" %}<path d="M1 6H25" stroke-width="1.5"/><rect x="10" y="3" width="6" height="6" stroke="none"/>
{%- else %}<rect x="5" y="1" width="16" height="10" stroke="none"/>{% endif %}</svg>{% endmacro %}
{% macro shown(picture) %}<figure>
{% if picture.legend %}<ul class="legend" aria-label="Legend">{% for entry in picture.legend %}<li>{{ mark(entry) }}{{ entry.words }}</li>{% endfor %}</ul>{% endif %}
{% for row in picture.rows %}<div class="row{% if row | rejectattr("fits_phones") | list %} scroll" role="group" tabindex="0" aria-label="Picture: {{ row[0].words or picture.caption }}{% endif %}" style="max-width: {{ row | sum(attribute="width") }}px">
{%- for panel in row %}<img{% if not panel.is_photograph %} class="drawn"{% endif %} style="flex: {{ panel.width }} 1 0; min-width: {{ panel.least_width }}" alt="{{ simulated.captioned(panel.words or picture.caption) }}" src="data:image/png;base64,{{ panel.encoded }}">{% endfor %}</div>
{% endfor %}<figcaption>{{ simulated.captioned(picture.caption) }}</figcaption></figure>{% endmacro %}
{% macro paragraphs(sentences) %}{% for kind, text in sentences %}<p{% if kind %} class="{{ kind }}"{% endif %}>{{ text | with_code }}</p>{% endfor %}{% endmacro %}
{% set open_sections = sections | rejectattr("is_folded") | list %}
<a class="skip" href="#content">Skip to the content</a>
<main id="content">
<h1>{{ title }}</h1>
{% if first_picture %}{{ shown(first_picture) }}{% endif %}
{{ paragraphs(sentences) }}
{% if open_sections | length > 4 %}<nav aria-label="On this page"><ul>{% for section in open_sections %}<li><a href="#part-{{ loop.index }}">{{ section.title }}</a></li>{% endfor %}</ul></nav>{% endif %}
{% for section in sections %}
{% if section.is_folded %}<details><summary><h2>{{ section.title }}</h2></summary>
{% else %}<h2 id="part-{{ open_sections.index(section) + 1 }}">{{ section.title }}</h2>{% endif %}
{{ paragraphs(section.sentences) }}
{% if section.rows %}<div class="scroll" role="region" tabindex="0" aria-label="Table: {{ section.title }}"><table><tr>
{%- for name in section.columns %}{% if name %}<th scope="col">{{ name }}</th>{% else %}<td></td>{% endif %}{% endfor %}</tr>
{% for row in section.rows %}<tr{% if section.is_glossary %} id="word-{{ row[0] }}"{% endif %}>{% for cell in row %}<td{% if cell is number %} class="number"{% elif cell | string | length > prose %} class="prose"{% endif %}>{{ "{:,}".format(cell) if cell is integer else cell }}</td>{% endfor %}</tr>
{% endfor %}</table></div>{% endif %}
{% for picture in section.pictures %}{{ shown(picture) }}{% endfor %}
{% for block in section.code %}<pre tabindex="0">{{ block }}</pre>{% endfor %}
{% if section.is_folded %}</details>{% endif %}
{% endfor %}
</main>
<footer>{{ footer }}</footer>
</body></html>
"""


SHOWN = 0.69
"""Pixels of a page for a pixel of a panel: panels are drawn finer than they are shown, for sharp screens."""
READABLE = 0.6
"""Share of its width on a large screen below which the words of a drawn panel are too small to be read."""
PHONE = 343
"""Width of the content of a page on a phone, px."""


@dataclass(frozen=True)
class Panel:
    """A part of a picture that stays whole.

    Parameters
    ----------
    png : bytes
        Content of a PNG file.
    pixels : int
        Width of the PNG.
    words : str
        What it shows, for people who do not see it; empty where the caption says it.
    is_photograph : bool
        Whether its colours are those of photographs, so that it looks the same on a dark page.
    """

    png: bytes
    pixels: int
    words: str = ""
    is_photograph: bool = False

    @property
    def width(self) -> int:
        """Width on a page, px."""
        return round(SHOWN * self.pixels)

    @property
    def fits_phones(self) -> bool:
        """Whether its words can be read at the width of a phone; one that does not fit is scrolled there."""
        return self.is_photograph or READABLE * self.width <= PHONE

    @property
    def least_width(self) -> str:
        """Least width on a page, in CSS."""
        if self.fits_phones:
            return f"min(100%, {min(self.width - 24, 208)}px)"
        return f"{round(READABLE * self.width)}px"

    @property
    def encoded(self) -> str:
        """Content of the panel as Base64 text."""
        return base64.b64encode(self.png).decode()


@dataclass(frozen=True)
class LegendEntry:
    """What one kind of mark in a picture means.

    Parameters
    ----------
    words : str
        Its meaning.
    colour : str
        Its colour, as ``"#2c5aa0"``.
    mark : str
        ``"dot"``, ``"line"``, ``"dashes"``, ``"square"``, ``"joined squares"``, ``"cross"``, ``"tick"`` or ``"box"``.
    """

    words: str
    colour: str
    mark: str


@dataclass(frozen=True)
class Picture:
    """Rows of panels with a caption, and a legend of the marks in them.

    Panels of a row stand side by side, and below one another where the page is too narrow.
    """

    rows: Sequence[Sequence[Panel]]
    caption: str
    legend: Sequence[LegendEntry] = ()


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
    is_glossary : bool
        Whether the first cell of each row is a word to which sentences lead that have it in square brackets.
    """

    title: str
    sentences: Sequence[tuple[str, str]] = ()
    columns: Sequence[str] = ()
    rows: Sequence[Sequence[object]] = ()
    pictures: Sequence[Picture] = field(default_factory=tuple)
    code: Sequence[str] = ()
    is_folded: bool = False
    is_glossary: bool = False


def render_page(
    title: str,
    sentences: Sequence[str | tuple[str, str]],
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
    sentences : sequence of str or (kind, text)
        Paragraphs before the first section, with kinds as in `Section`.
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
    words = frozenset(str(row[0]) for section in sections if section.is_glossary for row in section.rows)
    environment.filters["with_code"] = partial(_with_code, words=words)
    return environment.from_string(TEMPLATE).render(
        title=simulated.titled(title),
        sentences=[
            ("", sentence) if isinstance(sentence, str) else sentence
            for sentence in (*sentences, *filter(None, [simulated.sentence]))
        ],
        sections=sections,
        footer=footer,
        simulated=simulated,
        first_picture=first_picture,
        prose=PROSE,
    )


def _with_code(text: str, words: Collection[str] = ()) -> Markup:
    """Return a sentence as HTML, code between backticks set as such, and words of a glossary as links to it."""
    from markupsafe import Markup, escape

    coded = CODE.sub(r"<code>\1</code>", str(escape(text)))

    def linked(found: re.Match[str]) -> str:
        """Return a word in brackets as a link where the glossary has it."""
        return f'[<a href="#word-{found[1]}">{found[1]}</a>]' if found[1] in words else found[0]

    return Markup(WORD.sub(linked, coded))
