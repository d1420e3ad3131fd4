"""An HTTP server of a folder, slow or faulty where a test wants it."""

import contextlib
import http.server
import pathlib
import socketserver
import ssl
import subprocess
import threading
import time


class Answer:
    """What a fault makes of a request: a status, headers, a body; `None` as body: the file."""

    def __init__(self, status=200, headers=None, body=None, says_bytes=None, ends_after=None):
        self.status, self.headers, self.body = status, headers or {}, body
        self.says_bytes, self.ends_after = says_bytes, ends_after


class StoreServer(socketserver.ThreadingMixIn, http.server.HTTPServer):
    daemon_threads = True
    request_queue_size = 256
    allow_reuse_address = True

    def __init__(self, folder, delay_s=0.0, fault=None, gives_parts=True, tls=None, port=0):
        self.folder, self.delay_s, self.fault, self.gives_parts = pathlib.Path(folder), delay_s, fault, gives_parts
        self.requests, self.bytes, self.at_once, self.most_at_once, self.connections = [], 0, 0, 0, 0
        self.lock = threading.Lock()
        super().__init__(("127.0.0.1", port), Handler)
        if tls:
            context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
            context.load_cert_chain(*tls)
            self.socket = context.wrap_socket(self.socket, server_side=True)
        self.scheme = "https" if tls else "http"

    def url(self, path="", host="127.0.0.1"):
        return f"{self.scheme}://{host}:{self.server_port}/{path}"

    def handle_error(self, request, client_address):
        pass  # clients that leave


class Handler(http.server.BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"
    disable_nagle_algorithm = True
    wbufsize = -1

    def setup(self):
        super().setup()
        with self.server.lock:
            self.server.connections += 1

    def do_GET(self):
        server, name = self.server, self.path.lstrip("/")
        with server.lock:
            server.requests.append(name)
            server.at_once += 1
            server.most_at_once = max(server.most_at_once, server.at_once)
        try:
            time.sleep(server.delay_s)
            self.give(server.folder / name, server.fault(name) if server.fault else None)
        finally:
            with server.lock:
                server.at_once -= 1

    def give(self, file, fault):
        answer = fault or (Answer() if file.is_file() else Answer(404, body=b"none"))
        body = answer.body if answer.body is not None else file.read_bytes() if file.is_file() else b""
        status = answer.status
        wanted = self.headers.get("Range")
        if wanted and self.server.gives_parts and status == 200:
            first, last = wanted.removeprefix("bytes=").split("-")
            first, last = (max(len(body) - int(last), 0), len(body) - 1) if not first else (int(first), min(int(last), len(body) - 1))
            answer.headers["Content-Range"] = f"bytes {first}-{last}/{len(body)}"
            body, status = body[first : last + 1], 206
        self.send_response(status)
        for name, value in answer.headers.items():
            self.send_header(name, value)
        self.send_header("Content-Length", str(len(body) if answer.says_bytes is None else answer.says_bytes))
        self.end_headers()
        self.wfile.write(body[: answer.ends_after])
        self.wfile.flush()
        with self.server.lock:
            self.server.bytes += len(body)
        if answer.ends_after is not None or answer.says_bytes is not None:
            self.close_connection = True

    def log_message(self, *words):
        pass


@contextlib.contextmanager
def served(folder, **how):
    server = StoreServer(folder, **how)
    thread = threading.Thread(target=server.serve_forever, args=(0.02,), daemon=True)
    thread.start()
    try:
        yield server
    finally:
        server.shutdown()
        server.server_close()


def certificate(folder):
    """A certificate of localhost by nobody, and its key."""
    files = folder / "cert.pem", folder / "key.pem"
    subprocess.run(["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2", "-subj", "/CN=localhost",
                    "-addext", "subjectAltName=DNS:localhost", "-out", files[0], "-keyout", files[1]],
                   check=True, capture_output=True)
    return files
