"""What holds for every page in a real browser: nothing is cut, nothing is unreadable, and keys reach everything."""

from importlib.util import find_spec
from pathlib import Path

from browser import DESKTOP, PHONE, open_browser

OPEN_ALL = "document.querySelectorAll('details').forEach(part => part.open = true)"
TOO_WIDE = "document.documentElement.scrollWidth > innerWidth"
TALL_ROWS = "[...document.querySelectorAll('tr')].filter(row => row.offsetHeight > innerHeight).length"
PICTURES = "[...document.images].filter(image => !image.naturalWidth || !image.alt.trim()).length"
TINY = (
    "[...document.querySelectorAll('img.drawn')].filter(drawn => drawn.offsetWidth < 0.4 * drawn.naturalWidth).length"
)
INK = "getComputedStyle(document.body).color + ' on ' + getComputedStyle(document.body).backgroundColor"
AUDIT = (
    "axe.run({resultTypes: ['violations']}).then(told => told.violations.map("
    "fault => fault.id + ': ' + fault.nodes.slice(0, 3).map(node => node.html.slice(0, 120)).join(' | ')))"
)
FOCUSED = "document.activeElement.closest('summary, a, [tabindex]')?.innerText.split('\\n')[0] ?? ''"
LOOKS = {(DESKTOP, False): "light", (PHONE, True): "dark"}


def axe_script():
    """The auditor of accessibility, which the package axe-core-python brings; it needs no other package."""
    return (Path(find_spec("axe_core_python").origin).parent / "axe.min.js").read_text(encoding="utf-8")


async def faults_of(pages, folder):
    """Faults of pages in words, and how each page is drawn: ink on paper by page and look.

    Parameters
    ----------
    pages : dict, name -> Path
        Files of HTML.
    folder : Path
        For the browser's profile.
    """
    faults, inks = [], {}
    async with open_browser(folder, "--disable-gpu") as tab:
        for name, path in pages.items():
            for (width, is_dark), look in LOOKS.items():
                where = f"{name}, {width} px, {look}"
                await tab.show(width, is_dark)
                await tab.open(path.resolve().as_uri())
                inks[name, look] = await tab.run(INK)
                if width == DESKTOP:
                    faults += [f"{where}: {fault}" for fault in await _unreachable(tab)]
                await tab.run(OPEN_ALL)
                await tab.run(f"{axe_script()};0")
                faults += [f"{where}: {fault}" for fault in await tab.run(AUDIT)]
                faults += [f"{where}: wider than the window"] * (await tab.run(TOO_WIDE))
                faults += [f"{where}: a row of a table is higher than the window"] * (await tab.run(TALL_ROWS))
                faults += [f"{where}: a picture is not there, or has no words"] * (await tab.run(PICTURES))
                faults += [f"{where}: the words of a drawing are too small"] * (await tab.run(TINY))
                faults += [f"{where}: {error}" for error in tab.errors]
                tab.errors.clear()
    return faults, inks


async def _unreachable(tab):
    """What the Tab key does not reach, or Enter does not open: the link that skips, and each part that is folded."""
    await tab.press("Tab")
    if await tab.run(FOCUSED) != "Skip to the content":
        return ["the first key does not offer to skip to the content"]
    count = await tab.run("document.querySelectorAll('details').length")
    steps = await tab.run("document.querySelectorAll('a, summary, [tabindex]').length")
    for _ in range(steps):
        await tab.press("Tab")
        if await tab.run("document.activeElement.tagName") == "SUMMARY":
            await tab.press("Enter")
    opened = await tab.run("document.querySelectorAll('details[open]').length")
    return [] if opened == count else [f"keys open {opened} of {count} folded parts"]
