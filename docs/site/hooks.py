"""What MkDocs does to pages: the README is the first one, notebooks are pages, links out of the docs become paths."""

import json
import os
import re
from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

ROOT = Path(__file__).resolve().parents[2]
LINK = re.compile(
    r"(?P<picture>!?)\[(?P<words>[^\]]*)\]\((?P<target>(?!https?://|mailto:|#)[^)#\s]+)(?P<part>#[^)\s]*)?\)"
)


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the README as the first page, and a page for each notebook."""
    text = _moved((ROOT / "README.md").read_text(encoding="utf-8"), ROOT)
    files.append(File.generated(config, "index.md", content=text))
    for notebook in sorted((ROOT / "docs").glob("*.ipynb")):
        files.append(File.generated(config, f"{notebook.stem}.md", content=_page_of(notebook)))
    return files


def _page_of(notebook: Path) -> str:
    """Text and code of a notebook as a page; the notebook itself is a file beside it, to be downloaded."""
    cells = json.loads(notebook.read_text(encoding="utf-8"))["cells"]
    heading, *rest = [_block(cell["cell_type"], "".join(cell["source"])) for cell in cells]
    title, _, introduction = heading.partition("\n")
    moved = _moved("\n\n".join([introduction, *rest]), notebook.parent)
    return f"{title}\n\n[This page is a notebook]({notebook.name}): download it, and run it.\n{moved}"


def _block(kind: str, source: str) -> str:
    """A cell as Markdown: text as it is, code fenced by its language."""
    if kind == "markdown":
        return source
    magic, _, rest = source.partition("\n")
    return f"```bash\n{rest}\n```" if magic == "%%bash" else f"```python\n{source}\n```"


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Replace links that lead out of the docs by the paths of what they lead to."""
    return _moved(markdown, Path(page.file.abs_src_path).parent) if page.file.abs_src_path else markdown


def _moved(markdown: str, folder: Path) -> str:
    """Text whose links from ``folder`` lead to pages of the site, or are paths of the repository."""

    def moved(link: re.Match[str]) -> str:
        target = (folder / link["target"]).resolve()
        if target == ROOT / "README.md":
            start = os.path.relpath(ROOT / "docs" / "index.md", folder)
            return f"[{link['words']}]({start}{link['part'] or ''})"
        if not target.is_relative_to(ROOT / "docs"):
            return f"{link['words']} (`{target.relative_to(ROOT).as_posix()}`)"
        if target.is_dir():
            return f"{link['words']} (`{target.relative_to(ROOT).as_posix()}`)"
        if folder != ROOT:
            return link[0].replace(".ipynb)", ".md)")
        place = target.relative_to(ROOT / "docs").as_posix().replace(".ipynb", ".md")
        return f"{link['picture']}[{link['words']}]({place}{link['part'] or ''})"

    return LINK.sub(moved, markdown)
