"""Sphinx configuration: MyST pages, reference from docstrings, formulas as MathML, live pages.

Everything is local: no inventories are downloaded, and pages need no scripts from elsewhere. The
build writes a page of the viewer for each shipped mechanism to `live`; films link to these pages.
"""

import dataclasses
import logging
import re
import sys
from importlib.metadata import version as installed
from pathlib import Path
from xml.etree import ElementTree

from docutils import nodes
from docutils.utils.math.latex2mathml import tex2mathml

sys.path.insert(0, str(Path(__file__).resolve().parent))

import linkages
from linkages.reading.document import shipped

FILM = re.compile(r"gallery/([\w-]+)\.webp$")
MATHML = "http://www.w3.org/1998/Math/MathML"
ACCENTS = ("˙", "¨")

project = "linkages"
author = "the authors of linkages"
copyright = "the authors of linkages, MIT licence"  # noqa: A001
release = version = installed("linkages")

extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
exclude_patterns = ["_build", "_static"]
root_doc = "index"
nitpicky = False
default_role = "literal"
highlight_language = "text"

myst_enable_extensions = ["amsmath", "dollarmath", "colon_fence"]
myst_heading_anchors = 3
nb_execution_mode = "off"  # notebooks have their outputs: docs/make/notebooks.py

autodoc_member_order = "bysource"
autodoc_typehints = "signature"
python_use_unqualified_type_names = True
python_maximum_signature_line_length = 72
napoleon_google_docstring = False
napoleon_use_rtype = False
napoleon_attr_annotations = False

html_theme = "furo"
html_title = f"linkages {version}"
html_static_path = ["_static"]
html_css_files = ["pages.css"]
html_math_renderer = "local_mathml"
html_copy_source = False
html_show_sphinx = False


def _formula(writer, node, block):
    """Browsers draw MathML themselves, so that pages need no MathJax."""
    tree = ElementTree.fromstring(tex2mathml(node.astext(), as_block=block))
    _set_subscripts_beside(tree)
    ElementTree.register_namespace("", MATHML)
    writer.body.append(ElementTree.tostring(tree, encoding="unicode"))
    raise nodes.SkipNode


def _set_subscripts_beside(parent):
    """Docutils sets the subscript of a dotted letter below it; it belongs beside, with powers."""
    for place, child in enumerate(list(parent)):
        if child.tag == f"{{{MATHML}}}munderover" and child[2].text in ACCENTS:
            base, subscript, accent = child
            dotted = ElementTree.Element(f"{{{MATHML}}}mover", accent="true")
            dotted.extend([base, accent])
            beside = ElementTree.Element(f"{{{MATHML}}}msub")
            beside.extend([dotted, subscript])
            if parent.tag == f"{{{MATHML}}}msup" and place == 0:
                parent.tag = f"{{{MATHML}}}msubsup"
                parent[0] = dotted
                parent.insert(1, subscript)
            else:
                beside.tail = child.tail
                parent[place] = beside
        else:
            _set_subscripts_beside(child)


def _fields(_app, what, _name, found, _options, signature, returns):
    """Dataclasses show the names of their field types, not what those names stand for."""
    if what not in ("class", "exception") or not dataclasses.is_dataclass(found):
        return signature, returns
    parts = []
    for field in dataclasses.fields(found):
        kind = field.type if isinstance(field.type, str) else field.type.__name__
        default = "" if field.default is dataclasses.MISSING else f" = {field.default!r}"
        parts.append(f"{field.name}: {kind}{default}")
    return f"(*, {', '.join(parts)})", None


def _keys(_app, page, source):
    """Put the tables of keys and the list of components into their pages: found by themselves."""
    if page == "schema":
        from make.schema_tables import tables

        source[0] = source[0].replace("<!-- tables of keys -->", tables())
    if page == "api/components":
        from linkages.components.mechanisms.registry import components

        listed = "\n\n".join(f".. autoclass:: linkages.{name}" for name in components())
        marker = ".. all components of the package: conf.py puts them here"
        source[0] = source[0].replace(marker, listed)
    if page == "api/figures":
        from linkages.plots.charts import __all__ as charts

        listed = "\n\n".join(f".. autofunction:: linkages.plots.charts.{name}" for name in charts)
        source[0] = source[0].replace(".. all charts: conf.py puts them here", listed)


def _contents(_app, _page, source):
    """Tables of contents stand in comments: hosts of code would show a directive as text."""
    source[0] = re.sub(
        r"^<!-- toctree\n(.*?)^-->$", r"```{toctree}\n\1```", source[0], flags=re.S | re.M
    )


def _link_films(app, doctree, page):
    """Films link to the live page of their mechanism; the first film of all is that page itself."""
    if app.builder.format != "html":
        return
    for place, image in enumerate(list(doctree.findall(nodes.image))):
        film, link = FILM.search(image["uri"]), image.parent.parent
        if film is None or not isinstance(link, nodes.reference):
            continue
        live = f"{'../' * page.count('/')}live/{film[1]}.html"
        if page == root_doc and place == 0:
            frame = f'<iframe class="live" src="{live}#autoplay" title="{image["alt"]}"></iframe>'
            link.parent.replace(link, nodes.raw("", frame, format="html"))
        else:
            link["refuri"] = live


def _caption_figures(app, doctree, page):
    """A picture that is a paragraph of its own gets its words below, and a link to full size."""
    for place, image in enumerate(list(doctree.findall(nodes.image))):
        paragraph = image.parent
        if app.builder.format != "html" or not isinstance(paragraph, nodes.paragraph):
            continue
        if len(paragraph.children) > 1 or not image.get("alt") or "-drawing." in image["uri"]:
            continue
        _pages, file = app.env.images[image["uri"]]
        full = f"{'../' * page.count('/')}{app.builder.imagedir}/{file}"
        words = nodes.caption("", image["alt"])
        link = nodes.reference("", "", image, refuri=full, internal=True)
        paragraph.parent.replace(paragraph, nodes.figure("", link, words, ids=[f"figure-{place}"]))


def _improve_access(_app, _page, _template, context, _doctree):
    """Code that scrolls can be reached by the keyboard; signatures are no lists without terms."""
    if "body" in context:
        body = context["body"].replace("<pre>", '<pre tabindex="0">')
        context["body"] = re.sub(
            r'<dl>\s*(<dd><em class="sig-param">.*?)</dl>', _blocks, body, flags=re.DOTALL
        )


def _blocks(parameters):
    """The parameters of a signature, one block each."""
    return parameters[1].replace("<dd>", '<div class="sig-line">').replace("</dd>", "</div>")


def _write_live_pages(app, problem):
    """One page of the viewer for each shipped mechanism, 0.2 to 0.8 MB each."""
    logging.getLogger("linkages").setLevel(logging.WARNING)  # Sphinx shows what others log
    if problem is None and app.builder.format == "html":
        folder = Path(app.outdir, "live")
        folder.mkdir(exist_ok=True)
        for name in shipped():
            linkages.view(linkages.load(name), folder / f"{name}.html")


def setup(app):
    """Register the renderer of formulas, the signatures of dataclasses and the tables of keys."""
    app.connect("doctree-resolved", _link_films)
    app.connect("doctree-resolved", _caption_figures)
    app.connect("html-page-context", _improve_access)
    app.connect("build-finished", _write_live_pages)
    app.connect("source-read", _keys)
    app.connect("source-read", _contents)
    # both may have changed although their pages have not
    app.connect("env-get-outdated", lambda *_: ["api/components", "api/figures", "schema"])
    app.add_html_math_renderer(
        "local_mathml",
        inline_renderers=(lambda writer, node: _formula(writer, node, False), None),
        block_renderers=(lambda writer, node: _formula(writer, node, True), None),
    )
    app.connect("autodoc-process-signature", _fields)
