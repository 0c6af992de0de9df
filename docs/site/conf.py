"""Sphinx: the pages of docs/ and the reference. build.py runs it."""

import os
import pathlib
import re

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
WORK = pathlib.Path(os.environ["NSDAE_SITE"])

project = "nsdae"
author = "the authors of nsdae"
version = release = re.search(r"project\(nsdae VERSION ([0-9.]+)", (ROOT / "CMakeLists.txt").read_text())[1]
root_doc = "index"
extensions = ["myst_nb", "breathe", "sphinx.ext.autodoc", "numpydoc", "sphinx_gallery.gen_gallery"]
exclude_patterns = ["source/**", "gallery/*.ipynb", "gallery/*.py", "gallery/*.json", "gallery/*.md5", "gallery/*.zip"]

myst_enable_extensions = ["colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 4
myst_links_external_new_tab = False
nb_execution_mode = "cache"
nb_execution_cache_path = str(WORK / "notebooks")
nb_execution_raise_on_error = True
nb_execution_timeout = 120

breathe_projects = {"nsdae": str(WORK / "xml")}
breathe_default_project = "nsdae"
breathe_domain_by_extension = {"h": "c", "hpp": "cpp"}
breathe_show_include = False

autodoc_typehints = "none"  # the docstring says it
autodoc_member_order = "bysource"
numpydoc_show_class_members = False

sphinx_gallery_conf = {
    "examples_dirs": [str(WORK / "examples")],
    "gallery_dirs": ["gallery"],
    "within_subsection_order": "FileNameSortKey",
    "filename_pattern": "/plot_",
    "download_all_examples": False,
    "show_signature": False,
    "show_memory": False,
    "min_reported_time": 1e9,
    "matplotlib_animations": False,
    "remove_config_comments": True,
    "abort_on_example_error": True,
}

highlight_language = "text"  # of blocks that name none: equations, tables

html_theme = "furo"
html_title = f"nsdae {release}"
html_css_files = ["site.css"]
html_static_path = [str(pathlib.Path(__file__).parent / "static")]
html_copy_source = False
html_show_copyright = False


def formulas(app, what, name, obj, options, lines):
    """|u_T| in a docstring is a norm, not a substitution."""
    lines[:] = [re.sub(r"\|(\w+)\|", r"\\|\1\\|", line) for line in lines]


def setup(app):
    app.connect("autodoc-process-docstring", formulas, priority=600)  # after numpydoc
