"""The page itself: text of its parts, joined into one file."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from functools import cache
from html import escape
from importlib.resources import files
from typing import Any

from linkages.viewer.packed import deflated

SCRIPTS = (
    "content.js", "unpack.js", "units.js", "motion.js", "scene.js", "pace.js", "camera.js",
    "look.js", "shapes.js", "arrows.js", "glass.js", "ghost.js", "stage.js", "grip.js", "axes.js",
    "plot.js", "panels.js", "values.js", "player.js", "tabs.js", "hands.js", "live.js",
    "numbers.js", "change.js", "share.js", "main.js",
)  # fmt: skip
"""In the order in which the page reads them."""

_EXPORT = re.compile(r"^export ", re.MULTILINE)
"""Browsers start no modules beside a page that was opened from a disk, but scripts."""

_PLACE = re.compile(r"\{\{(\w+)\}\}")


def page(content: dict[str, Any], models: Mapping[str, str]) -> str:
    """The whole file.

    Parameters
    ----------
    content
        What scripts find in ``CONTENT``: numbers as text, the mechanism, its motion.
    models
        Name → module without imports that exports ``model``; empty for a model that is not there.
    """
    beside = [*(_named(*item) for item in models.items()), _asset("worker.js")]
    parts = {
        "title": escape(str(content["mechanism"]["name"])),
        "style": _asset("style.css"),
        "content": _json(content),
        "worker": deflated("\n".join(_EXPORT.sub("", text) for text in beside).encode()),
        "script": "\n".join(_asset(name) for name in SCRIPTS),
    }
    return _PLACE.sub(lambda found: parts[found[1]], _asset("page.html"))


def _named(name: str, module: str) -> str:
    """A module in a scope of its own, and its model under a name."""
    if not module:
        return f"const {name} = null;"
    return f"const {name} = (() => {{\n{module}\nreturn model;\n}})();"


def _json(content: dict[str, Any]) -> str:
    """JSON that cannot end the element that it stands in."""
    text = json.dumps(content, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c")


@cache
def _asset(name: str) -> str:
    return files("linkages.viewer").joinpath("assets", name).read_text(encoding="utf-8")
