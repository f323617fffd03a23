"""The site: sphinx with the pages of this folder. `make docs` builds it into out/site."""

from __future__ import annotations

project = "Toolpath compensator"
author = copyright = "The toolpath compensator developers"
extensions = ["myst_parser"]
source_suffix = {".md": "markdown"}
root_doc = "index"
exclude_patterns = ["images"]
html_theme = "furo"
html_title = project
html_copy_source = False
html_show_sourcelink = False
myst_heading_anchors = 3
myst_enable_extensions = ["colon_fence", "tasklist"]
# links to files of the repository beside docs/ lead out of the site, and examples of a shell are no lexer's
suppress_warnings = ["myst.xref_missing", "myst.header", "misc.highlighting_failure"]
highlight_language = "text"
