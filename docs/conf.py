"""The documentation, built by Sphinx: ``make docs``."""

import os

import fastdyn

project = "fastdyn"
author = "The fastdyn developers"
release = version = fastdyn.__version__

extensions = [
    "myst_parser",
    "numpydoc",
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
source_suffix = {".md": "markdown"}
exclude_patterns = ["conf.py"]
autosummary_generate = False
default_role = "code"  # `name` in docstrings
smartquotes = False

myst_enable_extensions = ["colon_fence", "dollarmath", "deflist"]
myst_heading_anchors = 4

autodoc_member_order = "bysource"
autodoc_typehints = "none"
autodoc_preserve_defaults = True
numpydoc_show_class_members = False
numpydoc_xref_param_type = False

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
