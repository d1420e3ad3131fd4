#!/usr/bin/env python3
"""Checks the pages; prints a line for each broken promise: check_pages.py

Links lead to existing files, headings and tests; every "Checked by" names a test; docs/embedding.md names each installed
header, and these include one another alone; docs/dependencies.md gives a reason for each package; the new names of
docs/changes.md are names of the sources.
"""

import pathlib
import re
import sys

root = pathlib.Path(__file__).resolve().parents[2]


def anchors_of(page):
    """Anchors of a page's headings, as GitHub makes them."""
    return [re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in re.findall(r"^#+ (.*)$", page, re.M)]


def broken_links(page, text):
    """(line, what) of the broken links. page: the path of the text."""
    for found in re.finditer(r"\]\(([^)#:\s]*)(?:#([^)\s]+))?\)", text):
        line, target = text.count("\n", 0, found.start()) + 1, page if not found[1] else page.parent / found[1]
        if not target.exists():
            yield line, f"links to {found[1]}, which is not there"
        elif found[2] and target.suffix == ".md" and found[2] not in anchors_of(text if target == page else target.read_text()):
            yield line, f"links to #{found[2]}, a heading that is not there"


def missing_tests(text, text_of_link):
    """Missing tests among a page's [`Suite.Name`](file.cpp) and [`test_name`](file.py)."""
    for name, link in re.findall(r"\[`([A-Z]\w*\.[A-Z]\w*|test_\w+)`\]\(([^)\s]+)\)", text):
        if not re.search(r"TEST(_F|_P)?\(" + name.replace(".", ", *") + r"\)|^def " + name + r"\(", text_of_link(link), re.M):
            yield name


def too_long(text):
    """(line, its beginning) of paragraphs of more than 250 words, and of cells of more than 100 words or 10 links."""
    in_code = False
    for number, line in enumerate(text.split("\n"), 1):
        in_code ^= line.startswith("```")
        is_row = line.startswith("|")
        for part in [] if in_code else line.split("|") if is_row else [line]:
            if len(part.split()) > (100 if is_row else 250) or is_row and part.count("](") > 10:
                yield number, part[:60]


def unknown_names(text, sources):
    """(line, name) of the names and headers in the second columns of the tables in docs/changes.md that sources lack.

    sources: the words and the headers that there are."""
    for number, line in enumerate(text.split("\n"), 1):
        cells = line.split(" | ") if line.startswith("| ") else []
        for code in re.findall(r"`([^`]+)`", cells[1]) if len(cells) > 1 else []:
            code = re.sub(r'"[^"]*"', "", code).replace("<palpa/", "<")
            for name in re.findall(r"[a-z_/]+\.h\b|[A-Za-z_][\w-]{2,}", code):
                if name not in sources:
                    yield number, name


def check():
    pages = [*sorted((root / "docs").rglob("*.md")), *sorted(root.glob("*.md"))]
    for page in pages:
        text, name = page.read_text(), page.relative_to(root)
        yield from ((name, *each) for each in broken_links(page, text))
        text_of = lambda link: (page.parent / link).read_text() if (page.parent / link).exists() else ""
        yield from ((name, 1, f"names the test {test}, which is not there") for test in missing_tests(text, text_of))
        yield from ((name, 1, f"names no test: {other}") for other in re.findall(r"\*Checked by\* (?!\[`).*", text))
        if name.name != "CHANGELOG.md":
            yield from ((name, line, f"is too long to be read: {part}") for line, part in too_long(text))
    cmake, embedding = (root / "palpa/CMakeLists.txt").read_text(), (root / "docs/embedding.md").read_text()
    lists = re.findall(r"(?:palpa_install_headers\(|foreach\(header )([^)]*)\)", cmake)
    headers = {"version.h", *re.findall(r"[a-z_0-9/]+\.h", " ".join(lists))}
    for header in sorted(headers):
        file = root / "palpa" / header
        if f"`{header}`" not in embedding:
            yield "docs/embedding.md", 1, f"does not name the installed header {header}"
        for other in re.findall(r'#include [<"]palpa/([^>"]+)[>"]', file.read_text() if file.exists() else ""):
            if other not in headers:
                yield f"palpa/{header}", 1, f"is installed and includes {other}, which is not"
    sources = {str(file.relative_to(root / "palpa")) for file in (root / "palpa").rglob("*.h")}
    sources.update(file.name for file in (root / "tools").iterdir())
    for file in [*(root / "palpa").rglob("*.h"), *(root / "python/palpa").glob("*.py"), *(root / "app").glob("*.cpp")]:
        sources.update(re.findall(r"[A-Za-z_][\w-]*", file.read_text()))
    changes = "docs/changes.md"
    yield from ((changes, line, f"has the new name {name}, which is not in the sources")
                for line, name in unknown_names((root / changes).read_text(), sources))
    packages = re.findall(r"^[a-z].*$", (root / "packages.txt").read_text(), re.M)
    reasons = (root / "docs/dependencies.md").read_text()
    yield from (("docs/dependencies.md", 1, f"gives no reason for {each}") for each in packages if f"`{each}`" not in reasons)
    if len(pages) < 30 or len(headers) < 10 or len(packages) < 10:
        yield ".", 1, f"not read: {len(pages)} pages, {len(headers)} headers, {len(packages)} packages"


if __name__ == "__main__":
    broken = [f"{path}:{line}: {what}" for path, line, what in check()]
    print(*broken, f"{len(broken)} promises are broken", sep="\n")
    sys.exit(bool(broken))
