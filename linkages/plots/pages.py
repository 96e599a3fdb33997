"""Pages that need no other file: their frame and look, tables, lists and figures."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Iterable, Sequence
from html import escape
from io import BytesIO
from string import Template

from matplotlib.figure import Figure

from linkages.plots import notebook
from linkages.plots.style import style

_PAGE = Template("""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width">
<title>$title</title>
<style>
body { font: 15px/1.5 system-ui, sans-serif; color: #1a1a1a; background: #fff;
       max-width: 54rem; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.6rem; margin: 0 0 .2rem; }
h2 { font-size: 1.1rem; margin: 2rem 0 .4rem; border-bottom: 1px solid #ddd; }
.source { color: #666; margin: 0 0 1rem; overflow-wrap: anywhere; }
.label { display: inline-block; color: #fff; border-radius: .3rem;
         font-size: 1.2rem; font-weight: 600; padding: .15rem .7rem; }
.changed { color: #b3420a; font-weight: 600; margin: .2rem 0; }
table { border-collapse: collapse; margin: .4rem 0; }
th, td { text-align: left; vertical-align: top; padding: .15rem 1.2rem .15rem 0;
         border-bottom: 1px solid #eee; }
td.n, th.n { text-align: right; font-variant-numeric: tabular-nums; }
.texts td.n, .texts th.n { text-align: left; }
figure { margin: 1.2rem 0; }
figure img { max-width: 100%; height: auto; display: block; }
figcaption { color: #555; font-size: .9rem; }
pre { font-size: .8rem; background: #f6f6f6; padding: .6rem; overflow-x: auto; }
@media print { body { max-width: none; margin: 0; font-size: 10pt; }
               figure, tr { break-inside: avoid; } pre { white-space: pre-wrap; } }
</style>
</head>
<body>
<h1>$title</h1>
<p class="source">$source</p>
$body
<p class="source">linkages $version</p>
</body>
</html>
""")


def page(title: str, source: str, changes: Sequence[str], body: Iterable[str]) -> str:
    """A page as HTML.

    Parameters
    ----------
    title, source
        What it is of, and the name of the file that defines it.
    changes
        In what that differs from its file.
    body
        Parts as HTML; empty ones are left out.
    """
    from importlib.metadata import version

    differs = [f'<p class="changed">{escape(spaced(text))}</p>' for text in changes]
    return _PAGE.substitute(
        title=escape(title),
        source=escape(source),
        body="\n".join([*differs, *(part for part in body if part)]),
        version=version("linkages"),
    )


def spaced(change: str) -> str:
    """An assignment as people read it."""
    return change.replace("=", " = ", 1)


def section(heading: str, *parts: str) -> str:
    """A heading with what stands under it; nothing if that is empty."""
    text = "\n".join(part for part in parts if part)
    return f"<h2>{escape(heading)}</h2>\n{text}" if text else ""


def paragraph(text: str) -> str:
    """A text of its own."""
    return f"<p>{escape(text)}</p>" if text else ""


def items(texts: Iterable[str]) -> str:
    """A list of texts; nothing if there are none."""
    found = "\n".join(f"<li>{escape(text)}</li>" for text in texts)
    return f"<ul>\n{found}\n</ul>" if found else ""


def table(heads: Sequence[str], rows: Sequence[Sequence[str]], *, texts: bool = False) -> str:
    """A table; all cells but the first of a row are numbers, unless they are texts."""
    found = notebook.table(heads, rows)
    return f'<div class="texts">{found}</div>' if texts else found


def definition(text: str) -> str:
    """The text of a definition, folded."""
    return f"<details><summary>Definition</summary><pre>{escape(text)}</pre></details>"


def picture(figure: Figure) -> bytes:
    """A figure as PNG."""
    stream = BytesIO()
    with style():
        figure.savefig(stream, format="png", metadata={"Software": None})
    return stream.getvalue()


def figure_with(figure: Figure, text: str) -> str:
    """A figure over its caption."""
    source, caption = b64encode(picture(figure)).decode("ascii"), escape(text)
    return (
        f'<figure><img alt="{caption}" src="data:image/png;base64,{source}">'
        f"<figcaption>{caption}</figcaption></figure>"
    )
