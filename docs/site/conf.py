"""Settings of Sphinx for the site. `build.py` assembles the pages and starts Sphinx."""

import sys
from importlib.metadata import version as installed
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path.insert(0, str(HERE))

from numpydoc.xref import DEFAULT_LINKS

from references import full_names

project = "fieldrecon"
author = "The fieldrecon developers"
version = release = installed("fieldrecon")
html_title = f"fieldrecon {version}"
language = "en"
smartquotes = False  # phi'(r) is a formula

extensions = [
    "sphinx.ext.autodoc",
    "sphinx.ext.viewcode",
    "numpydoc",
    "myst_parser",
    "sphinx_gallery.gen_gallery",
    "docstrings",
    "drawings",
    "gallery_figures",
    "chapters",
    "references",
]
source_suffix = {".rst": "restructuredtext", ".md": "markdown", ".chapter": "chapter"}
myst_heading_anchors = 4
myst_enable_extensions = ["colon_fence"]
suppress_warnings = ["config.cache"]  # the order of the gallery is a function

# The reference. Sphinx does not look up names of other projects, which would need a network.
default_role = "py:obj"
add_module_names = False
autodoc_typehints = "none"  # the types stand in the docstrings, in the words of NumPy
autodoc_member_order = "bysource"
autodoc_default_options = {
    "members": True,
    "inherited-members": "tuple",
    "special-members": "__call__",
}
numpydoc_show_class_members = False
numpydoc_xref_param_type = True
numpydoc_xref_ignore = "all"  # except these; types of Python and NumPy stay text
numpydoc_xref_aliases = {name: name for name in DEFAULT_LINKS} | full_names()

# The gallery. Times of computation, which differ from build to build, are not written.
sphinx_gallery_conf = {
    "examples_dirs": str(ROOT / "examples" / "gallery"),
    "gallery_dirs": "gallery",
    "filename_pattern": r"\.py$",
    "within_subsection_order": "FileNameSortKey",
    "abort_on_example_error": True,
    "backreferences_dir": "gallery/backreferences",
    "doc_module": ("fieldrecon",),
    "reference_url": {"fieldrecon": None},
    "thumbnail_size": (280, 200),
    "capture_repr": (),
    "download_all_examples": False,
    "min_reported_time": 1e9,
    "remove_config_comments": True,
    "show_memory": False,
    "show_signature": False,
    "write_computation_times": False,
    "reset_modules": ("matplotlib", "gallery_figures.reset"),
    "image_scrapers": ("gallery_figures.scraper",),
}

html_theme = "furo"
templates_path = [str(HERE / "templates")]
html_static_path = [str(HERE / "static")]
html_css_files = ["site.css"]
html_js_files = [("reader.js", {"defer": "defer"})]
html_copy_source = False
html_search_scorer = str(HERE / "search_scores.js")
html_show_sphinx = False
html_show_copyright = False
html_last_updated_fmt = None
html_permalinks_icon = "#"
html_show_search_summary = False  # a page opened as a file may not read other files
pygments_style = "xcode"
pygments_dark_style = "github-dark"
