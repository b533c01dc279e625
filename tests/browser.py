"""A real browser for tests: one headless process, driven over its debugging socket."""

import asyncio
import base64
import re
import shutil
import subprocess
from contextlib import asynccontextmanager

import cv2
import numpy as np

BROWSER = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
OPTIONS = (
    "--headless=new",
    "--no-sandbox",
    "--disable-dev-shm-usage",
    "--remote-debugging-port=0",
    "--hide-scrollbars",
)
DESKTOP, PHONE = 1280, 400
"""Widths of a window, px."""


class Tab:
    """A tab of the browser.

    Parameters
    ----------
    socket : aiohttp.ClientWebSocketResponse
        Socket of the tab.
    """

    def __init__(self, socket):
        self._socket = socket
        self._number = 0
        self.errors = []
        """Errors of the console since they were last cleared, in words."""
        self._loaded = False

    async def send(self, method, **parameters):
        """The result of a command of the browser; errors of the console that come meanwhile are kept."""
        self._number += 1
        number = self._number
        await self._socket.send_json({"id": number, "method": method, "params": parameters})
        while True:
            message = await self._socket.receive_json()
            self._note(message)
            if message.get("id") == number:
                if "error" in message:
                    raise RuntimeError(f"{method}: {message['error']}")
                return message["result"]

    def _note(self, message):
        self.errors += error_of(message)
        self._loaded = self._loaded or message.get("method") == "Page.loadEventFired"

    async def show(self, width, is_dark):
        """Give the window a width, and ask for a dark or a light look."""
        await self.send("Emulation.setDeviceMetricsOverride", width=width, height=900, deviceScaleFactor=1,
                        mobile=width < 600)  # fmt: skip
        look = {"name": "prefers-color-scheme", "value": "dark" if is_dark else "light"}
        await self.send("Emulation.setEmulatedMedia", features=[look])

    async def open(self, address):
        """Load a page, and wait until it is there."""
        self._loaded = False
        await self.send("Page.navigate", url=address)
        while not self._loaded:
            self._note(await asyncio.wait_for(self._socket.receive_json(), 60))

    async def run(self, script):
        """The value of a piece of JavaScript; a promise is awaited."""
        told = await self.send("Runtime.evaluate", expression=script, awaitPromise=True, returnByValue=True)
        if "exceptionDetails" in told:
            raise RuntimeError(str(told["exceptionDetails"]))
        return told["result"].get("value")

    async def press(self, key):
        """Press and release a key, such as ``"Tab"`` or ``"Enter"``."""
        code = {"Tab": 9, "Enter": 13}[key]
        text = {"text": "\r"} if key == "Enter" else {}
        for kind in ("keyDown", "keyUp"):
            await self.send("Input.dispatchKeyEvent", type=kind, key=key, code=key, windowsVirtualKeyCode=code, **text)

    async def picture(self, is_whole=False):
        """The window, or the whole page, as an RGB picture (H, W, 3)."""
        told = await self.send("Page.captureScreenshot", format="png", captureBeyondViewport=is_whole)
        return cv2.imdecode(np.frombuffer(base64.b64decode(told["data"]), np.uint8), cv2.IMREAD_COLOR_RGB)


@asynccontextmanager
async def open_browser(folder, *options):
    """A tab of a new browser whose profile lies in a folder; the browser ends with the block."""
    import aiohttp

    browser = subprocess.Popen(
        [BROWSER, *OPTIONS, *options, f"--user-data-dir={folder}", "about:blank"],
        stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    try:
        port = next(found[1] for line in browser.stderr if (found := re.search(r"ws://[\d.]+:(\d+)/", line)))
        async with aiohttp.ClientSession() as session:
            async with session.get(f"http://127.0.0.1:{port}/json") as answer:
                (facts,) = [tab for tab in await answer.json() if tab["type"] == "page"]
            async with session.ws_connect(facts["webSocketDebuggerUrl"], max_msg_size=0) as socket:
                tab = Tab(socket)
                for domain in ("Runtime", "Log", "Page"):
                    await tab.send(f"{domain}.enable")
                yield tab
    finally:
        browser.terminate()
        browser.communicate()


def error_of(message):
    """The errors in a message of the browser, in words."""
    method, told = message.get("method"), message.get("params", {})
    if method == "Runtime.consoleAPICalled" and told["type"] in ("error", "assert"):
        return [" ".join(str(part.get("value", part.get("description", ""))) for part in told["args"])]
    if method == "Log.entryAdded" and told["entry"]["level"] == "error":
        return [told["entry"]["text"]]
    return [str(told)] if method == "Runtime.exceptionThrown" else []
