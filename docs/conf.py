"""Configuration of Sphinx."""

import os
import sys
from pathlib import Path

FOLDER = Path(__file__).parent
sys.path[:0] = [str(FOLDER.parent), str(FOLDER.parent / "derivations" / "evidence")]

import symfric  # noqa: E402
from docs.kept import sources_key  # noqa: E402
from docs.once import prepare_for_pages  # noqa: E402

prepare_for_pages()

project = "symfric"
author = "the symfric developers"
project_copyright = author
version = release = symfric.__version__
html_title = f"symfric {version}"

extensions = ["sphinx.ext.autodoc", "numpydoc", "myst_nb", "sphinx_copybutton", "docs.pages"]
copybutton_prompt_text = r">>> |\.\.\. |\$ "
copybutton_prompt_is_regexp = True
exclude_patterns = ["_build", "**.py", "**.in.md"]
nitpicky = False
default_role = "literal"  # docstrings write names in single backticks

autodoc_member_order = "bysource"
autodoc_typehints = "none"  # the sections of the docstrings have them
add_module_names = False
numpydoc_show_class_members = False
numpydoc_attributes_as_param_list = True

myst_enable_extensions = ["colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3
nb_execution_mode = "force" if os.environ.get("SYMFRIC_DOCS_FRESH") else "cache"
nb_execution_cache_path = str(FOLDER / "_build" / "jupyter" / sources_key("examples"))
nb_execution_in_temp = True
nb_execution_timeout = 300
nb_execution_raise_on_error = True
nb_merge_streams = True

html_theme = "furo"
html_static_path = ["_static"]
html_extra_path = ["gallery/extra"]
(Path(__file__).parent / "gallery" / "extra").mkdir(exist_ok=True)  # looked for before the gallery fills it
html_css_files = ["symfric.css"]
html_copy_source = False
html_show_sphinx = False
