"""The documentation as a site: `make docs` writes build/docs/index.html, warnings being errors.

Pages are the Markdown files of this folder; the reference of the Python packages is made from their
docstrings, which are plain text: the first paragraph as a sentence, the rest as it stands.
"""

import importlib
import os
import re
import shutil
from pathlib import Path

import matplotlib
from docutils import nodes
from latex2mathml.converter import convert

project = "GranuLab"
author = "The GranuLab developers"
copyright = author
html_title = "GranuLab"

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.viewcode",
    "sphinx_design",
    "sphinx_gallery.gen_gallery",
]
exclude_patterns = ["examples", "results/silo2d", "results/damper3d"]
html_theme = "furo"
html_theme_options = {"source_edit_link": ""}
html_show_sphinx = False
html_copy_source = False
html_static_path = ["static"]
html_css_files = ["equations.css"]
html_math_renderer = "mathml"  # in the page itself: no script, no network

myst_enable_extensions = ["colon_fence", "dollarmath"]
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_timeout = 600  # [s] of a cell; the first one compiles
nb_execution_in_temp = True
nb_merge_streams = True
myst_heading_anchors = 4  # the anchors that pages link to, as they are on code hosts
suppress_warnings = ["myst.header"]  # a page may go from # to ###, as where a table follows

# The gallery runs in a copy, so that run folders of its examples do not lie among the pages, and as
# a whole each time, as the packages may have changed. An assertion that fails stops the build.
matplotlib.use("Agg")
DOCS = Path(__file__).parent
EXAMPLES = DOCS.parent / "build" / "gallery"
shutil.rmtree(EXAMPLES, ignore_errors=True)
shutil.copytree(DOCS / "examples" / "gallery", EXAMPLES)
sphinx_gallery_conf = {
    "examples_dirs": str(EXAMPLES),
    "gallery_dirs": "gallery",
    "subsection_order": [
        os.path.relpath(EXAMPLES / name, DOCS)
        for name in ("silo", "damper", "laboratory", "contacts")
    ],
    "filename_pattern": r"/plot_",
    "run_stale_examples": True,
    "abort_on_example_error": True,
    "capture_repr": (),
    "image_scrapers": ("matplotlib",),
    "reset_modules": ("matplotlib",),
    "notebook_extensions": set(),
    "show_memory": False,
    "show_signature": False,
    "download_all_examples": False,
    "write_computation_times": False,
    "thumbnail_size": (320, 224),
}

# Public names are loaded on first use; autodoc sees those that are there.
for name in ("granulab.contact", "granulab.campaign", "silo2d", "damper3d", "calibration"):
    package = importlib.import_module(name)
    for public in package.__all__:
        getattr(package, public)

autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_preserve_defaults = True
autodoc_default_options = {"members": True, "undoc-members": False, "inherited-members": False}


def as_text(_app, _what, _name, _thing, _options, lines: list[str]) -> None:
    """Keep blocks of a docstring that stand in columns as they are; the others are sentences."""
    blocks = re.split(r"\n\s*\n", "\n".join(lines).strip())
    found: list[str] = []
    for block in blocks:
        own = block.splitlines()
        if any(line.startswith(" ") or "   " in line.strip() for line in own):
            found += [".. code-block:: text", "", *(f"   {line}" for line in own), ""]
        else:
            text = re.sub(r"([*|\\])|_(?!\w)", lambda m: "\\" + m.group(), " ".join(own))
            found += [re.sub(r"`([^`]+)`", r"``\1``", text), ""]
    lines[:] = found


FUNCTION = r"(<mi>(?:ln|sin|cos|tan|cot|arcsin|arccos)</mi>)(?=<m(?:i|n|frac|sub)>)"


def equation(writer, node) -> None:
    """Write an equation as MathML: inline, or as a block that scrolls in its own box."""
    block = isinstance(node, nodes.math_block)
    mathml = convert(node.astext(), display="block" if block else "inline")
    mathml = re.sub(FUNCTION, r'\1<mspace width="0.17em" />', mathml)  # as LaTeX spaces them
    if block:
        name = f' id="{node["ids"][0]}"' if node["ids"] else ""
        mathml = f'<div class="equation"{name} tabindex="0">{mathml}</div>\n'
    writer.body.append(mathml)
    raise nodes.SkipNode


def setup(app) -> None:
    """Hook docstrings and equations in."""
    app.connect("autodoc-process-docstring", as_text)
    app.add_html_math_renderer("mathml", (equation, None), (equation, None))
