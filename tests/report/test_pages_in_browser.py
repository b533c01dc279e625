"""All pages in one session of a real browser: they keep the laws of pages, and a page that breaks them is found."""

import asyncio

import pytest
from browser import BROWSER
from copied_trees import copy_tree
from made_pages import calibration, diagnosed_table, proof, report_and_replay, written
from page_laws import faults_of

BROKEN = """<!doctype html><html lang="en"><head><title>Broken</title></head><body><main>
<a href="#a" tabindex="-1">Skip</a><h1>Broken</h1><p style="color: #999; background: #fff">pale</p>
<img src="data:image/png;base64,AAAA" style="width: 3000px; height: 9px">
<img class="drawn" alt="tiny" style="width: 0"
src="data:image/gif;base64,R0lGODlhAQABAAAAACH5BAEKAAEALAAAAAABAAEAAAICTAEAOw==">
<details><summary tabindex="-1">closed</summary>a</details>
<table><tr style="height: 200vh"><td>high</td></tr></table>
<script>console.error("an error of its own")</script></main></body></html>"""
SAID = (
    "skip",
    "color-contrast",
    "image-alt",
    "wider than the window",
    "a picture is not there",
    "a row of a table is higher",
    "the words of a drawing are too small",
    "an error of its own",
)


@pytest.mark.slow
@pytest.mark.skipif(BROWSER is None, reason="no browser")
def test_pages_keep_their_laws(tiny_store, tmp_path):
    """No error, nothing wider than a phone, enough contrast, words for pictures, keys that open; one look for all."""
    pytest.importorskip("aiohttp")
    pytest.importorskip("axe_core_python")
    copy_tree(tiny_store, tmp_path / "ds.zarr")
    report, replay = report_and_replay(tmp_path / "ds.zarr", tmp_path / "out")
    pages = {
        "report": report,
        "replay": replay,
        "calibration": calibration(tmp_path),
        "table": diagnosed_table(tmp_path),
        "proof": proof(tmp_path),
        "broken": written(tmp_path / "broken.html", BROKEN),
    }
    faults, inks = asyncio.run(faults_of(pages, tmp_path / "profile"))
    # a control: every law is broken by a page that is made to break it
    broken = [fault for fault in faults if fault.startswith("broken")]
    assert [words for words in SAID if not any(words in fault for fault in broken)] == []
    assert [fault for fault in faults if fault not in broken] == []
    looks = {look: {ink for (name, which), ink in inks.items() if which == look and name != "broken"} for look in
             ("light", "dark")}  # fmt: skip
    assert {look: len(ink) for look, ink in looks.items()} == {"light": 1, "dark": 1}
    assert looks["light"] != looks["dark"]
