"""Sphinx configuration: MyST pages, reference from docstrings, formulas as MathML.

Everything is local: no inventories are downloaded, and pages need no scripts from elsewhere.
"""

import dataclasses
import re
import sys
from importlib.metadata import version as installed
from pathlib import Path
from xml.etree import ElementTree

from docutils import nodes
from docutils.utils.math.latex2mathml import tex2mathml

sys.path.insert(0, str(Path(__file__).resolve().parent))

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
nb_execution_mode = "off"  # notebooks have their outputs: docs/run_notebooks.py

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
        from schema_tables import tables

        source[0] = source[0].replace("<!-- tables of keys -->", tables())
    if page == "api":
        from linkages.components.mechanisms.registry import components

        listed = "\n\n".join(f".. autoclass:: linkages.{name}" for name in components())
        marker = ".. all components of the package: conf.py puts them here"
        source[0] = source[0].replace(marker, listed)
        from linkages.plots.charts import __all__ as charts

        listed = "\n\n".join(f".. autofunction:: linkages.plots.charts.{name}" for name in charts)
        source[0] = source[0].replace(".. all charts: conf.py puts them here", listed)


def _contents(_app, _page, source):
    """Tables of contents stand in comments: hosts of code would show a directive as text."""
    source[0] = re.sub(
        r"^<!-- toctree\n(.*?)^-->$", r"```{toctree}\n\1```", source[0], flags=re.S | re.M
    )


def setup(app):
    """Register the renderer of formulas, the signatures of dataclasses and the tables of keys."""
    app.connect("source-read", _keys)
    app.connect("source-read", _contents)
    # both may have changed although their pages have not
    app.connect("env-get-outdated", lambda *_: ["api", "schema"])
    app.add_html_math_renderer(
        "local_mathml",
        inline_renderers=(lambda writer, node: _formula(writer, node, False), None),
        block_renderers=(lambda writer, node: _formula(writer, node, True), None),
    )
    app.connect("autodoc-process-signature", _fields)
