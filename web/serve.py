#!/usr/bin/env python3
"""Serves the page on the loopback address, for this machine alone.

Usage: web/serve.py [FOLDER] [--port PORT]

FOLDER: made by tools/make-web; default build/web. PORT: default 8765, else the next free one. Ctrl-C ends it.
"""

import argparse
import functools
import http.server
import pathlib
import sys

from policy import policy

HEADERS = {
    "Content-Security-Policy": policy(),
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "X-Frame-Options": "DENY",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-cache",
}
TYPES = {".js": "text/javascript", ".wasm": "application/wasm", ".toml": "text/plain; charset=utf-8", ".svg": "image/svg+xml"}


class Files(http.server.SimpleHTTPRequestHandler):
    """Files of one folder, without lists of folders."""

    extensions_map = {**http.server.SimpleHTTPRequestHandler.extensions_map, **TYPES}

    def end_headers(self) -> None:
        for name, value in HEADERS.items():
            self.send_header(name, value)
        super().end_headers()

    def parse_request(self) -> bool:
        if not super().parse_request():
            return False
        # A foreign name that leads to this machine (DNS rebinding) gets nothing.
        host = self.headers.get("Host", "").rsplit(":", 1)[0]
        if host in ("127.0.0.1", "localhost"):
            return True
        self.send_error(421, "this server is for 127.0.0.1 alone")
        return False

    def list_directory(self, path):
        self.send_error(404)

    def log_message(self, format, *args):
        pass


def server_on(folder: pathlib.Path, port: int) -> http.server.ThreadingHTTPServer:
    handler = functools.partial(Files, directory=str(folder))
    last_error: OSError | None = None
    for number in [port] if port == 0 else range(port, port + 20):
        try:
            return http.server.ThreadingHTTPServer(("127.0.0.1", number), handler)
        except OSError as error:
            last_error = error
    raise SystemExit(f"serve.py: no free port from {port} on: {last_error}")


def main() -> None:
    root = pathlib.Path(__file__).resolve().parent.parent
    parser = argparse.ArgumentParser(description="Serves Palpa's page on the loopback address.")
    parser.add_argument("folder", nargs="?", type=pathlib.Path, default=root / "build/web")
    parser.add_argument("--port", type=int, default=8765, help="default 8765; 0: any free one")
    arguments = parser.parse_args()
    if not (arguments.folder / "index.html").is_file():
        raise SystemExit(f"serve.py: {arguments.folder}: has no page; make it by tools/make-web")
    with server_on(arguments.folder, arguments.port) as server:
        print(f"http://127.0.0.1:{server.server_address[1]}/", flush=True)
        try:
            server.serve_forever()
        except KeyboardInterrupt:
            sys.stdout.write("\n")


if __name__ == "__main__":
    main()
