"""Definition files with a few things changed at random, as structure and as text.

What is changed is drawn by hypothesis, so that a failure shrinks to few changes.
"""

import copy
import re
from importlib.resources import files
from pathlib import Path

import yaml
from definition_parts import KEYS, LAWS, VALUES, parts
from hypothesis import strategies as st

ROOT = Path(__file__).parents[2]
MOST_CHANGES = 4
NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?")
DAMAGE = ("\t", "\n", " ", ":", "- ", "{", "}", "[", "]", "'", '"', "&a ", "*a", "<<: ", "#", "|",
          "!!python/object ", "%", "\x00", "\u2028", "é", "𝜑", "\ufeff", "−", "?", "---\n", "...\n",
          "[" * 50, "{a: " * 40, "1e999", "nan", ".inf")  # fmt: skip


def sources():
    """All definitions of the repository: shipped ones, those of other tests, templates."""
    folders = (ROOT / "mechanisms", ROOT / "tests/data/linkages")
    paths = [path for folder in folders for path in sorted(folder.glob("*.yaml"))]
    templates = files("linkages") / "cli/templates"
    texts = [path.read_text(encoding="utf-8") for path in paths]
    return [*texts, *((templates / f"{name}.yaml").read_text(encoding="utf-8")
                      for name in ("empty", "four-bar", "nine-bar", "slider-crank"))]  # fmt: skip


SOURCES = sources()
READ = [yaml.load(text, Loader=yaml.BaseLoader) for text in SOURCES]


def places(content, path=()):
    """Paths of all entries, the outermost first."""
    entries = content.items() if isinstance(content, dict) else enumerate(content)
    found = []
    for key, value in entries:
        found.append((*path, key))
        if isinstance(value, dict | list):
            found += places(value, (*path, key))
    return found


def container(content, path):
    """What holds the last step of a path."""
    for step in path[:-1]:
        content = content[step]
    return content


@st.composite
def changed_contents(draw):
    """A definition as nested mappings, lists and texts, with one to four changes."""
    content = copy.deepcopy(draw(st.sampled_from(READ)))
    for _ in range(draw(st.integers(1, MOST_CHANGES))):
        found = places(content)
        if not found:
            break
        draw(st.sampled_from(CHANGES))(draw, content, found)
    return content


@st.composite
def changed_files(draw):
    """The text of a definition: changed as a structure, or damaged as a text."""
    if draw(st.integers(0, 9)):
        return yaml.safe_dump(draw(changed_contents()), allow_unicode=True, sort_keys=False)
    text = draw(st.sampled_from(SOURCES))
    for _ in range(draw(st.integers(1, 3))):
        at = draw(st.integers(0, len(text)))
        kind = draw(st.integers(0, 3))
        if kind == 0:
            text = text[:at]
        elif kind == 1:
            text = text[:at] + text[at + draw(st.integers(1, 30)) :]
        elif kind == 2:
            line = text[text.rfind("\n", 0, at) + 1 :].partition("\n")[0]
            text = f"{text}\n{line}\n"
        else:
            text = text[:at] + draw(st.sampled_from(DAMAGE)) + text[at:]
    return text


def remove(draw, content, found):
    path = draw(st.sampled_from(found))
    del container(content, path)[path[-1]]


def repeat(draw, content, found):
    """The same entry once more, under another name: a twin of a bar, two equal plates."""
    path = draw(st.sampled_from([p for p in found if len(p) == 2] or found))
    holder = container(content, path)
    twin = copy.deepcopy(holder[path[-1]])
    if isinstance(holder, list):
        holder.append(twin)
    else:
        holder[f"{path[-1]}x"] = twin


def rename(draw, content, found):
    path = draw(st.sampled_from(found))
    holder = container(content, path)
    if isinstance(holder, dict):
        keys = [p[-1] for p in found if isinstance(p[-1], str)]
        holder[draw(st.sampled_from([*KEYS, *keys]))] = holder.pop(path[-1])


def replace_value(draw, content, found):
    path = draw(st.sampled_from(found))
    container(content, path)[path[-1]] = copy.deepcopy(draw(st.sampled_from((*VALUES, *LAWS))))


def rescale(draw, content, found):
    """A number of another size or sign, its unit kept."""
    texts = [p for p in found if isinstance(container(content, p)[p[-1]], str)]
    numbers = [p for p in texts if NUMBER.match(container(content, p)[p[-1]])]
    if numbers:
        path = draw(st.sampled_from(numbers))
        text = container(content, path)[path[-1]]
        power = draw(st.sampled_from((*range(-4, 5), -300, -150, -30, -12, 12, 30, 150, 300)))
        sign = draw(st.sampled_from(("", "", "", "-")))
        matched = NUMBER.match(text)
        factor = draw(st.sampled_from((1.0, 0.5, 1.7, 0.0)))
        changed = float(matched.group()) * factor
        container(content, path)[path[-1]] = f"{sign}{changed!r}*1e{power}{text[matched.end() :]}"


def exchange_names(draw, content, found):
    """A name where another one stood: joints swapped, drives moved to other bodies."""
    names = sorted({p[1] for p in found if len(p) == 2 and isinstance(p[1], str)} | joints(content))
    used = [p for p in found if container(content, p)[p[-1]] in names]
    if used:
        path = draw(st.sampled_from(used))
        container(content, path)[path[-1]] = draw(st.sampled_from(names))


def exchange(draw, content, found):
    """Two entries change places."""
    first, second = draw(st.sampled_from(found)), draw(st.sampled_from(found))
    if first[: len(second)] == second or second[: len(first)] == first:
        return
    one, other = container(content, first), container(content, second)
    one[first[-1]], other[second[-1]] = other[second[-1]], one[first[-1]]


def add(draw, content, found):
    """One more component, at joints and bodies that there are."""
    bodies = [p[1] for p in found if len(p) == 2 and p[0] in ("bars", "sliders")] or ["x"]
    section, name, entry = draw(parts(sorted(joints(content)) or ["A"], bodies))
    entry = copy.deepcopy(entry)  # a law in it is that of all files, and may be changed in this one
    holder = content.get(section)
    if name == "":  # a section of its own
        content[section] = entry
    elif name is None:
        content[section] = [*(holder if isinstance(holder, list) else []), entry]
    else:
        content[section] = {**(holder if isinstance(holder, dict) else {}), name: entry}


def joints(content):
    """Names that look like joints."""
    found = set(content["joints"]) if isinstance(content.get("joints"), dict) else set()
    for bar in content["bars"].values() if isinstance(content.get("bars"), dict) else ():
        own = bar.get("joints") or bar.get("points") or () if isinstance(bar, dict) else ()
        found |= {name for name in own if isinstance(name, str)}
    return found


CHANGES = (
    remove, repeat, rename, replace_value, replace_value, rescale, rescale, exchange_names,
    exchange, add, add,
)  # fmt: skip
