"""One browser for all tests of the page, and pages of shipped mechanisms."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from browser import Browser, Page

import linkages
from linkages.kernel.system import System
from linkages.solution.solution import Solution
from linkages.viewer.recorded import wanted


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    with Browser() as found:
        yield found


@pytest.fixture(scope="session")
def solved() -> Callable[..., Solution]:
    """A motion with all that a page shows, computed once."""
    known: dict[Any, Solution] = {}

    def solve(name: str, **options: Any) -> Solution:
        key = (name, *sorted(options.items()))
        if key not in known:
            mechanism = linkages.load(name)
            outputs = wanted(System(mechanism))
            known[key] = linkages.simulate(mechanism, outputs=outputs, throw=False, **options)
        return known[key]

    return solve


@pytest.fixture(scope="session")
def written(
    solved: Callable[..., Solution], tmp_path_factory: pytest.TempPathFactory
) -> Callable[[str], Path]:
    """The file of a mechanism's page, written once."""
    folder = tmp_path_factory.mktemp("viewer")

    def write(name: str) -> Path:
        file = folder / f"{name}.html"
        return file if file.exists() else linkages.view(solved(name), file)

    return write


@pytest.fixture
def opened(browser: Browser, written: Callable[[str], Path]) -> Callable[..., Page]:
    """A page of a mechanism, with its parts in `v`."""

    def opening(name: str, *, size: tuple[int, int] = (1300, 900), dark: bool = False) -> Page:
        page = browser.page(*size, dark=dark)
        page.open(written(name))
        page.evaluate("viewer.then((parts) => { window.v = parts; })")
        return page

    return opening
