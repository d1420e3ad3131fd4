"""Checks a site's internal links: every linked page, picture and anchor exists.

Usage: check_links.py SITE
Prints each broken link; exit status 1 if there is one. Links to other sites are not followed.
"""

import html.parser
import pathlib
import sys
import urllib.parse


class Page(html.parser.HTMLParser):
    def __init__(self, path):
        super().__init__()
        self.links, self.anchors = [], set()
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attributes):
        for name, value in attributes:
            if name == "id" or (tag == "a" and name == "name"):
                self.anchors.add(value)
            elif name in ("href", "src") and value:
                self.links.append(value)


site = pathlib.Path(sys.argv[1]).resolve()
pages = {path: Page(path) for path in sorted(site.rglob("*.html"))}
links = broken = elsewhere = 0
for path, page in pages.items():
    for link in page.links:
        parts = urllib.parse.urlsplit(link)
        if parts.scheme or parts.netloc:
            # Links for readers only: a page loads nothing from elsewhere.
            elsewhere += 1
            continue
        links += 1
        target = (path.parent / urllib.parse.unquote(parts.path)).resolve() if parts.path else path
        anchor = urllib.parse.unquote(parts.fragment)
        if not target.is_file():
            print(f"{path.relative_to(site)}: '{link}' leads to nothing", file=sys.stderr)
            broken += 1
        elif anchor and target in pages and anchor not in pages[target].anchors:
            print(f"{path.relative_to(site)}: '{link}': that page has no such place", file=sys.stderr)
            broken += 1
print(f"{len(pages)} pages, {links} links within, {elsewhere} to elsewhere, {broken} that lead nowhere")
sys.exit(1 if broken or not links else 0)
