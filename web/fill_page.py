#!/usr/bin/env python3
"""Fills the page's marks: policy, examples, addresses of the documentation.

Usage: fill_page.py PAGE FOLDER DOCS CONTENTS; prints the page. FOLDER has the scenes; DOCS is the documentation's address or
empty; CONTENTS is esbuild's metafile, which says what the page loads next: the browser fetches it at once.
"""

import html
import json
import pathlib
import re
import sys

from policy import policy

page, folder, docs, contents = sys.argv[1:5]
first = "head_phantom.toml"


def option(scene: pathlib.Path) -> str:
    title = re.search(r'^title\s*=\s*"(.*)"', scene.read_text(encoding="utf-8"), re.MULTILINE)
    words = title.group(1).split(":")[0] if title else scene.stem
    chosen = " selected" if scene.name == first else ""
    return f'<option value="{html.escape(scene.name)}"{chosen}>{html.escape(words)}</option>'


def loaded_next() -> list[str]:
    """Scripts of the page's larger part, app.ts, with all that they import."""
    outputs = json.loads(pathlib.Path(contents).read_text(encoding="utf-8"))["outputs"]
    due = [name for name, made in outputs.items() if made.get("entryPoint", "").endswith("app.ts")]
    found: list[str] = []
    while due:
        name = due.pop()
        if name in found:
            continue
        found.append(name)
        due += [one["path"] for one in outputs[name]["imports"] if one["kind"] == "import-statement"]
    return sorted(pathlib.PurePath(name).name for name in found)


scenes = sorted(pathlib.Path(folder, "scenes").glob("*.toml"), key=lambda scene: (scene.name != first, scene.name))
docs = docs.rstrip("/")
marks = {
    "@POLICY@": html.escape(policy(in_page=True)),
    "@EXAMPLES@": "".join(option(scene) for scene in scenes),
    "@NEXT@": "".join(f'<link rel="modulepreload" href="{name}">\n' for name in loaded_next()),
    "@SAFETY@": html.escape(f"{docs}/safety.html#not-promised" if docs else "safety.txt"),
    "@DOCS@": html.escape(f"{docs}/explorer.html" if docs else "licenses.txt"),
    "@DOCS_WORDS@": "documentation" if docs else "licenses",
}
text = pathlib.Path(page).read_text(encoding="utf-8")
for mark, words in marks.items():
    text = text.replace(mark, words)
sys.stdout.write(text)
