"""A headless Chromium for tests, spoken to over a pipe: no port, no package, no network.

Its protocol: https://chromedevtools.github.io/devtools-protocol/
"""

from __future__ import annotations

import base64
import fcntl
import json
import os
import select
import shutil
import signal
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

PROGRAM = next(
    (found for name in ("chromium", "chromium-browser", "google-chrome", "chrome")
     if (found := shutil.which(name))), None
)  # fmt: skip

needs_browser = pytest.mark.skipif(
    PROGRAM is None or not hasattr(os, "posix_spawn"), reason="needs Chromium on the PATH"
)

ANSWER_IN = 120.0
"""Seconds without a word from the browser after which it has failed, however busy the machine."""

ARGUMENTS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--remote-debugging-pipe", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-dev-shm-usage",
    "--hide-scrollbars", "--mute-audio", "about:blank",
)  # fmt: skip


class Browser:
    """A process of Chromium; a context manager."""

    def __init__(self) -> None:
        assert PROGRAM is not None
        self._profile = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        theirs_in, self._out = _pipe()
        self._in, theirs_out = _pipe()
        places = [(os.POSIX_SPAWN_DUP2, theirs_in, 3), (os.POSIX_SPAWN_DUP2, theirs_out, 4)]
        quiet = [(os.POSIX_SPAWN_OPEN, fd, os.devnull, os.O_WRONLY, 0) for fd in (1, 2)]
        command = [PROGRAM, f"--user-data-dir={self._profile.name}", *ARGUMENTS]
        self._process = os.posix_spawn(
            PROGRAM, command, os.environ, file_actions=[*quiet, *places], setpgroup=0
        )
        os.close(theirs_in)
        os.close(theirs_out)
        self._last, self._buffer = 0, b""
        self.events: list[dict[str, Any]] = []

    def __enter__(self) -> Browser:
        return self

    def __exit__(self, *_: object) -> None:
        os.killpg(self._process, signal.SIGKILL)
        os.waitpid(self._process, 0)
        os.close(self._in)
        os.close(self._out)
        self._profile.cleanup()

    def call(self, method: str, session: str | None = None, /, **parameters: Any) -> Any:
        """What the browser answers to a command; what else it says meanwhile is kept."""
        self._last += 1
        message: dict[str, Any] = {"id": self._last, "method": method, "params": parameters}
        if session is not None:
            message["sessionId"] = session
        data = json.dumps(message).encode() + b"\0"
        while data:
            data = data[os.write(self._out, data) :]
        while True:
            heard = self._hear()
            if heard.get("id") == self._last:
                assert "error" not in heard, f"{method}: {heard['error']}"
                return heard["result"]
            self.events.append(heard)

    def _hear(self) -> dict[str, Any]:
        while b"\0" not in self._buffer:
            assert select.select([self._in], [], [], ANSWER_IN)[0], "the browser says nothing"
            heard = os.read(self._in, 1 << 20)
            assert heard, "the browser has ended"
            self._buffer += heard
        message, _, self._buffer = self._buffer.partition(b"\0")
        found: dict[str, Any] = json.loads(message)
        return found

    def page(self, width: int = 1300, height: int = 900, *, dark: bool = False) -> Page:
        """A new empty page of a size in pixels."""
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        found = self.call("Target.attachToTarget", targetId=target, flatten=True)
        page = Page(self, found["sessionId"])
        page.call("Emulation.setDeviceMetricsOverride", width=width, height=height,
                  deviceScaleFactor=1, mobile=width < 600)  # fmt: skip
        look = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        page.call("Emulation.setEmulatedMedia", features=[look])
        return page


class Page:
    """A page or a frame: what it is asked, what is done with it, and what it complained of."""

    def __init__(self, browser: Browser, session: str) -> None:
        self.browser, self._session = browser, session
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")

    def call(self, method: str, /, **parameters: Any) -> Any:
        """What the browser answers to a command for this page."""
        return self.browser.call(method, self._session, **parameters)

    def open(self, file: Path) -> None:
        """Open a file from the disk."""
        self.call("Page.navigate", url=file.absolute().as_uri())
        self.evaluate("new Promise(done => document.readyState == 'complete'"
                      " ? done() : addEventListener('load', () => done()))")  # fmt: skip

    def frame(self) -> Page:
        """The only frame on the page, one that has no part in what is around it."""
        how = {"autoAttach": True, "waitForDebuggerOnStart": False, "flatten": True}
        self.call("Target.setAutoAttach", **how)
        (found,) = (
            event["params"]["sessionId"]
            for event in self._own()
            if event["method"] == "Target.attachedToTarget"
            and event["params"]["targetInfo"]["type"] == "iframe"
        )
        return Page(self.browser, found)

    def evaluate(self, expression: str) -> Any:
        """The value of an expression of JavaScript, or of the promise that it is."""
        found = self.call("Runtime.evaluate", expression=expression, awaitPromise=True,
                          returnByValue=True)  # fmt: skip
        assert "exceptionDetails" not in found, found["exceptionDetails"]
        return found["result"].get("value")

    def press(self, key: str) -> None:
        """Press and release a key, such as ``ArrowRight`` or a space."""
        text = {"text": key} if len(key) == 1 else {}
        code = "Space" if key == " " else key
        self.call("Input.dispatchKeyEvent", type="keyDown", key=key, code=code, **text)
        self.call("Input.dispatchKeyEvent", type="keyUp", key=key, code=code)

    def drag(self, *points: tuple[float, float]) -> None:
        """Press the mouse at the first point, lead it along the others, and let go."""
        (x, y), (last_x, last_y) = points[0], points[-1]
        button: dict[str, Any] = {"button": "left", "clickCount": 1}
        mouse: Callable[..., Any] = lambda **what: self.call("Input.dispatchMouseEvent", **what)  # noqa: E731
        mouse(type="mouseMoved", x=x, y=y)
        mouse(type="mousePressed", x=x, y=y, **button)
        for x, y in points[1:]:
            mouse(type="mouseMoved", x=x, y=y, button="left", buttons=1)
        mouse(type="mouseReleased", x=last_x, y=last_y, **button)

    def screenshot(self, path: Path, element: str = "body") -> None:
        """Write what is seen of an element as PNG."""
        x, y, width, height = self.evaluate(
            "(({ left, top, width, height }) => [left, top, width, height])"
            f"(document.querySelector({element!r}).getBoundingClientRect())"
        )
        clip = {"x": x, "y": y, "width": width, "height": height, "scale": 1}
        found = self.call("Page.captureScreenshot", clip=clip)
        path.write_bytes(base64.b64decode(found["data"]))

    @property
    def complaints(self) -> list[str]:
        """Errors and warnings on the console, exceptions that nobody caught."""
        found = []
        for event in self._own():
            what = event["params"]
            if event["method"] == "Runtime.exceptionThrown":
                found.append(json.dumps(what["exceptionDetails"])[:2000])
            elif event["method"] == "Runtime.consoleAPICalled":
                if what["type"] in ("error", "warning", "assert"):
                    found.append(json.dumps(what["args"])[:2000])
            elif event["method"] == "Log.entryAdded":
                found.append(what["entry"]["text"])
        return found

    @property
    def requests(self) -> list[str]:
        """Addresses that the page asked for, itself among them."""
        methods = ("Network.requestWillBeSent", "Network.webSocketCreated")
        own = [event["params"] for event in self._own() if event["method"] in methods]
        return [what["request"]["url"] if "request" in what else what["url"] for what in own]

    def _own(self) -> list[dict[str, Any]]:
        self.call("Runtime.evaluate", expression="0")  # what happened before is told by then
        return [event for event in self.browser.events if event.get("sessionId") == self._session]


def _pipe() -> tuple[int, int]:
    """Both ends of a pipe, numbered so high that they are none of those of a child."""
    ends = os.pipe()
    high = [fcntl.fcntl(end, fcntl.F_DUPFD_CLOEXEC, 10) for end in ends]
    for end in ends:
        os.close(end)
    return high[0], high[1]
