"""Sphinx's configuration for tools/make-docs: the repository's Markdown unchanged, with links to sources.

The source folder is made by tools/make-docs: links to the repository's pages, and beside them `api`, made of the public
headers. PALPA_SOURCE names the repository.
"""

import html
import os
import pathlib
import posixpath
import re

from docutils import nodes
from pygments import highlight
from pygments.formatters import HtmlFormatter
from pygments.lexers import get_lexer_for_filename
from pygments.lexers.special import TextLexer
from pygments.util import ClassNotFound
from sphinx import addnodes
from sphinx.util.osutil import relative_uri

repository = pathlib.Path(os.environ["PALPA_SOURCE"])

project = "Palpa"
version = release = re.search(r"project\([^)]*?VERSION (\d[\d.]*)", (repository / "CMakeLists.txt").read_text(encoding="utf-8")).group(1)
author = "the authors of Palpa"
copyright = author
root_doc = "README"
language = "en"

extensions = ["myst_parser"]
source_suffix = {".md": "markdown"}
myst_heading_anchors = 6
myst_enable_extensions = []
primary_domain = "cpp"
highlight_language = "none"  # blocks without a language are drawings, messages or commands

html_theme = "furo"
html_title = f"Palpa {release}"
html_static_path = ["static"]
html_css_files = ["palpa.css"]
html_copy_source = False
html_show_sphinx = False
html_last_updated_fmt = None
html_use_index = False
pygments_style = "friendly"
pygments_dark_style = "monokai"
html_theme_options = {
    "light_css_variables": {"color-brand-primary": "#0b5c72", "color-brand-content": "#0b6a86"},
    "dark_css_variables": {"color-brand-primary": "#6cc4d8", "color-brand-content": "#7fd0e3"},
}

# The navigation beside each page. A page of docs that is missing here is an error of the build: no reader would find it.
navigation = [
    ("Begin", ["start", "concepts", "gallery", "glossary"]),
    ("Feel", ["modes/README", "scene", "tools", "/scenes/README", "data", "large", "hands", "devices", "safety", "explorer", "browser", "trace", "check", "map"]),
    ("Program", ["python", "embedding", "c", "own-mode", "/api/index", "/api/python", "paraview", "slicer"]),
    ("Theory", ["theory", "path", "laws"]),
    ("Study", ["felt", "beside", "reproduction", "benchmark", "/bench/haptics/README"]),
    ("Within", ["design", "contracts/README", "far", "security", "limits", "dependencies", "changes", "/CHANGELOG", "/CONTRIBUTING", "/SECURITY"]),
]
folders_of_pages = {"docs/modes/README": "docs/modes", "docs/contracts/README": "docs/contracts", "docs/design": "docs/design"}


def toctree(pages, caption=""):
    options = ":hidden:\n" + (f":caption: {caption}\n" if caption else "")
    return "\n\n```{toctree}\n" + options + "\n" + "\n".join(pages) + "\n```\n"


def add_navigation(app, docname, source):
    """The pages' hierarchy, which the pages themselves do not contain, and the way to the page for browsers, if it is there."""
    way = os.environ.get("PALPA_TRY")
    if way and docname in (root_doc, "docs/browser"):
        source[0] += f'\n\n<p><a href="{posixpath.relpath(way, posixpath.dirname(docname) or ".")}"><strong>Try it</strong></a> in this browser.</p>\n'
    if docname == root_doc:
        for caption, pages in navigation:
            names = [page if page.startswith("/") else f"/docs/{page}" for page in pages]
            source[0] += toctree([name for name in names if name[1:] in app.env.found_docs], caption)
    elif docname in folders_of_pages:
        folder = folders_of_pages[docname] + "/"
        source[0] += toctree([f"/{page}" for page in sorted(app.env.found_docs) if page.startswith(folder) and page != docname])


def source_page(path):
    """The page that shows a file or a folder of the repository."""
    return "source/" + path + ("/index" if (repository / path).is_dir() else "")


def link_sources(app, doctree):
    """Redirects links to sources and folders to pages that show them."""
    here = app.env.docname
    shown = app.env.palpa_sources
    links = [node for node in doctree.traverse(lambda n: isinstance(n, (addnodes.pending_xref, addnodes.download_reference)))]
    for node in links:
        target, _, anchor = node.get("reftarget", "").partition("#")
        if not target:
            continue
        path = posixpath.normpath(posixpath.join(posixpath.dirname(here), target))
        if path.startswith("..") or not (repository / path).exists():
            continue
        if path.endswith(".md") and path[:-3] in app.env.found_docs:
            continue
        if path + "/README" in app.env.found_docs:
            page = path + "/README"
        else:
            page = source_page(path)
            shown.add(path)
        reference = nodes.reference("", "", *node.children, internal=True, refuri=relative_uri(app.builder.get_target_uri(here),
                                                                                              app.builder.get_target_uri(page)))
        node.replace_self(reference)


source_template = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1"><title>{path} - Palpa</title>
<link rel="stylesheet" href="{top}_static/pygments.css"><link rel="stylesheet" href="{top}_static/source.css"></head>
<body data-theme="auto"><script>document.body.dataset.theme = localStorage.getItem("theme") || "auto"</script>
<nav><a href="{top}index.html">Palpa</a> <span>{path}</span></nav><main>{body}</main></body></html>
"""


def is_text(path):
    return (repository / path).is_file() and b"\0" not in (repository / path).read_bytes()[:4096]


def lexer_of(path):
    try:
        return get_lexer_for_filename(path)
    except ClassNotFound:
        return TextLexer()


def show_sources(app, problem):
    """Writes the pages of the linked files and folders, and of the files directly in those folders."""
    if problem or app.builder.format != "html":
        return
    folders = {path for path in app.env.palpa_sources if (repository / path).is_dir()}
    inside = {folder: sorted(f"{folder}/{entry.name}" for entry in (repository / folder).iterdir() if entry.name[0] not in "._")
              for folder in folders}
    files = {path for path in app.env.palpa_sources.union(*inside.values()) if is_text(path)}
    bodies = {}
    for path in files:
        text = (repository / path).read_text(encoding="utf-8", errors="replace")
        bodies[path] = highlight(text, lexer_of(path), HtmlFormatter(cssclass="highlight"))
    for folder, paths in inside.items():
        rows = []
        for path in paths:
            name = html.escape(posixpath.basename(path)) + ("/" if (repository / path).is_dir() else "")
            if path in files or path in folders:
                name = f'<a href="{relative_uri(source_page(folder) + ".html", source_page(path) + ".html")}">{name}</a>'
            rows.append(f"<li>{name}</li>")
        bodies[folder] = f"<ul>{''.join(rows)}</ul>"
    for path, body in bodies.items():
        page = source_page(path) + ".html"
        out = pathlib.Path(app.outdir) / page
        out.parent.mkdir(parents=True, exist_ok=True)
        out.write_text(source_template.format(path=html.escape(path), top="../" * page.count("/"), body=body), encoding="utf-8")


def join_scripts(app, problem):
    """Merges the two script modules of Debian's furo, as no browser loads an import from a file.

    Without it there is no switch between light and dark, and the list of a page's headings does not follow.
    """
    folder = pathlib.Path(app.outdir) / "_static/scripts"
    if problem or not folder.is_dir():
        return
    script = (folder / "furo.js").read_text(encoding="utf-8")
    used = 'import Gumshoe from "./gumshoe-patched.js";\n'
    if script.startswith(used):
        other = (folder / "gumshoe-patched.js").read_text(encoding="utf-8")
        (folder / "furo.js").write_text(other + script.removeprefix(used), encoding="utf-8")


def begin(app, env, docnames):
    env.palpa_sources = set()


def setup(app):
    app.connect("env-before-read-docs", begin)
    app.connect("source-read", add_navigation)
    app.connect("doctree-read", link_sources, priority=100)  # before files to download are gathered
    app.connect("build-finished", show_sources)
    app.connect("build-finished", join_scripts)
    return {"parallel_read_safe": False}
