"""The documentation, built by Sphinx: ``make docs``."""

import os
import pathlib
import runpy
import shutil

import fastdyn
from fastdyn.pages import site
from fastdyn.problem.options.table import ALL_OPTIONS

project = "fastdyn"
author = "The fastdyn developers"
release = version = fastdyn.__version__

extensions = [
    "myst_nb",
    "numpydoc",
    "sphinx-mathjax-offline",  # formulas are set where there is no network, too
    "sphinx.ext.autodoc",
    "sphinx_copybutton",
    "sphinx_design",
]
if os.environ.get("FASTDYN_INTERSPHINX") == "on":  # links to other documentation: needs the network
    extensions.append("sphinx.ext.intersphinx")
    intersphinx_mapping = {
        "python": ("https://docs.python.org/3", None),
        "numpy": ("https://numpy.org/doc/stable", None),
        "scipy": ("https://docs.scipy.org/doc/scipy", None),
    }
source_suffix = {".md": "myst-nb", ".ipynb": "myst-nb"}
exclude_patterns = ["conf.py", "pages"]
autosummary_generate = False
default_role = "code"  # `name` in docstrings
smartquotes = False

HERE = pathlib.Path(__file__).parent
shutil.rmtree(HERE / "notebooks", ignore_errors=True)
shutil.copytree(HERE.parent / "notebooks", HERE / "notebooks")  # Sphinx reads its own folder only
nb_execution_mode = "force"
notebooks = runpy.run_path(str(HERE.parent / ".ci" / "notebooks.py"))
nb_execution_excludepatterns = [  # shown as stored, where a library is missing
    path.name for path in notebooks["FOLDER"].glob("*.ipynb") if not notebooks["runnable"](path)
]
nb_execution_timeout = 300
nb_execution_raise_on_error = True
nb_merge_streams = True

myst_enable_extensions = ["colon_fence", "dollarmath", "deflist"]
myst_heading_anchors = 4

autodoc_member_order = "bysource"
autodoc_typehints = "none"
autodoc_preserve_defaults = True
numpydoc_show_class_members = False
numpydoc_xref_param_type = False

site.build(HERE / "pages" / "try")  # all systems, live
html_extra_path = ["pages"]

html_sidebars = {"index": [], "benchmarks": [], "six_tasks": []}
html_theme = "pydata_sphinx_theme"
html_title = "fastdyn"
html_static_path, html_css_files = ["_static"], ["fastdyn.css"]
html_copy_source = False
html_theme_options = {
    "show_toc_level": 2,
    "navigation_with_keys": False,
    "secondary_sidebar_items": ["page-toc"],
    "footer_start": ["copyright"],
    "footer_end": [],
}


def setup(app):
    """Put each option into the index, so that a search for an option leads to its entry first."""

    def indexed(app, what, name, obj, options, lines):
        if name == "fastdyn.solve_ivp":
            entries = [f"   ! single: {one.name}" for one in ALL_OPTIONS]
            lines[:0] = [".. index::", *entries, ""]

    app.connect("autodoc-process-docstring", indexed)
    app.extensions["sphinx-mathjax-offline"].parallel_read_safe = True  # copies files, reads none
