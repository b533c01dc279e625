"""What MkDocs does to pages: the README is the first one, and links to files beside the docs become their paths."""

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
    """Add the README as the first page."""
    text = _moved((ROOT / "README.md").read_text(encoding="utf-8"), ROOT)
    files.append(File.generated(config, "index.md", content=text))
    return files


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Replace links that lead out of the docs by the paths of what they lead to."""
    return _moved(markdown, Path(page.file.abs_src_path).parent) if page.file.abs_src_path else markdown


def _moved(markdown: str, folder: Path) -> str:
    """Text whose links from ``folder`` lead to pages of the site, or are paths of the repository."""

    def moved(link: re.Match[str]) -> str:
        target = (folder / link["target"]).resolve()
        if not target.is_relative_to(ROOT / "docs"):
            return f"{link['words']} (`{target.relative_to(ROOT).as_posix()}`)"
        if target.is_dir():
            return f"{link['words']} (`{target.relative_to(ROOT).as_posix()}`)"
        if folder != ROOT:
            return link[0]
        place = target.relative_to(ROOT / "docs").as_posix()
        return f"{link['picture']}[{link['words']}]({place}{link['part'] or ''})"

    return LINK.sub(moved, markdown)
