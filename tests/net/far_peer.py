"""Both ends of palpa's network on plain sockets, for wrong and hostile ones: WebSockets (RFC 6455) and messages (docs/far.md)."""

import base64
import hashlib
import os
import socket
import struct

HELLO, WELCOME, PROBES, MODEL, DATAGRAMS = 1, 2, 3, 4, 128
TEXT, BINARY, CLOSE, PING, PONG = 1, 2, 8, 9, 10
ALPHABET = "0123456789ABCDEFGHJKMNPQRSTVWXYZ"


def token_bytes(text):
    bits = "".join(f"{ALPHABET.index(letter):05b}" for letter in text.replace("-", ""))
    return bytes(int(bits[8 * n:8 * n + 8], 2) for n in range(16))


def message(kind, payload, time_us=0):
    return struct.pack("<HBBIQ", 1, kind, 0, 16 + len(payload), time_us) + payload


def hello(token, role=1, name=b"a hand"):
    return message(HELLO, token_bytes(token) + struct.pack("<B4d", role, 5.0, 2000.0, 5.0, 0.0) + name.ljust(32, b"\0"))


def probes(number, position_m, time_us=0):
    sample = struct.pack("<3dfIB", *position_m, 1e-3, 0, 1)
    felt = struct.pack("<3d3f3fBBfQQ3f", *position_m, *[0.0] * 6, 0, 0, 0.0, 0, 0, 0.0, 0.0, 0.0)
    return message(PROBES, struct.pack("<QB", number, 1) + sample + felt, time_us)


def welcome(scene=1, stiffness_n_per_m=1000.0, max_force_n=1000.0):
    return message(WELCOME, struct.pack("<I4dH", scene, stiffness_n_per_m, 0.0, max_force_n, 0.0, 0))


def row(kind=2, flags=0, strength_n=1.0, stiffness=float("inf"), offset=(0, 0, 0), direction=(0, 0, 1)):
    return struct.pack("<BBHHBB4f9f", kind, flags, 0, 0, 0, 0, strength_n, 0.0, stiffness, 0.0, *offset, *direction, 0, 0, 0)


def model(answers, echo_us, proxy_m, rows, count=None, held_s=0.0):
    return message(MODEL, struct.pack("<QIQ3f3dH", answers, 1, echo_us, held_s, 0.0, 1.0, *proxy_m, len(rows) if count is None else count)
                   + b"".join(rows))


class WebSocket:
    """One end, blocking. What is received of frames is what a conforming peer sends: unfragmented."""

    def __init__(self, connection, masks):
        self.connection, self.masks, self.bytes = connection, masks, b""

    @classmethod
    def client(cls, port, host=None, origin=None, target="/", address="127.0.0.1"):
        """Raises ConnectionRefusedError with the answer if the request is not granted."""
        self = cls(socket.create_connection((address, port), timeout=20), True)
        lines = [f"GET {target} HTTP/1.1", f"Host: {host or f'127.0.0.1:{port}'}", "Upgrade: websocket", "Connection: Upgrade",
                 "Sec-WebSocket-Version: 13", "Sec-WebSocket-Key: " + base64.b64encode(os.urandom(16)).decode()]
        if origin:
            lines.append(f"Origin: {origin}")
        self.connection.sendall("\r\n".join(lines + ["", ""]).encode())
        answer = self.head()
        if " 101 " not in answer.split("\r\n")[0]:
            while piece := self.connection.recv(4096):
                self.bytes += piece
            raise ConnectionRefusedError(answer + self.bytes.decode())
        return self

    @classmethod
    def server(cls, connection):
        self = cls(connection, False)
        key = next(line.split(": ")[1] for line in self.head().split("\r\n") if line.lower().startswith("sec-websocket-key"))
        accept = base64.b64encode(hashlib.sha1((key + "258EAFA5-E914-47DA-95CA-C5AB0DC85B11").encode()).digest()).decode()
        connection.sendall(("HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                            f"Sec-WebSocket-Accept: {accept}\r\n\r\n").encode())
        return self

    def head(self):
        while b"\r\n\r\n" not in self.bytes:
            piece = self.connection.recv(4096)
            if not piece:
                return self.bytes.decode()
            self.bytes += piece
        head, self.bytes = self.bytes.split(b"\r\n\r\n", 1)
        return head.decode()

    def send(self, payload, kind=BINARY):
        length = len(payload)
        mask = 128 if self.masks else 0
        head = bytes([128 | kind]) + (bytes([mask | length]) if length < 126 else bytes([mask | 126]) + struct.pack(">H", length)
                                      if length < 65536 else bytes([mask | 127]) + struct.pack(">Q", length))
        self.connection.sendall(head + (bytes(4) if self.masks else b"") + payload)  # a mask of zeros

    def take(self, count):
        while len(self.bytes) < count:
            piece = self.connection.recv(65536)
            if not piece:
                raise EOFError
            self.bytes += piece
        taken, self.bytes = self.bytes[:count], self.bytes[count:]
        return taken

    def receive(self):
        """(kind, payload) of the next frame; pings are answered."""
        while True:
            first, length = self.take(2)
            masked, length = length & 128, length & 127
            if length == 126:
                length = struct.unpack(">H", self.take(2))[0]
            elif length == 127:
                length = struct.unpack(">Q", self.take(8))[0]
            mask = self.take(4) if masked else bytes(4)
            payload = self.take(length)
            if any(mask):
                payload = bytes(byte ^ mask[n % 4] for n, byte in enumerate(payload))
            if first & 15 != PING:
                return first & 15, payload
            self.send(payload, PONG)

    def reason(self):
        """Why the peer closes: text of its close frame; "" without one."""
        try:
            while True:
                kind, payload = self.receive()
                if kind == CLOSE:
                    return payload[2:].decode()
        except (EOFError, ConnectionError):
            return ""

    def close(self):
        self.connection.close()
