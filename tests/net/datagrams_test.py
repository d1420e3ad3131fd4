#!/usr/bin/env python3
"""Datagrams of palpa serve and run --data-at, and what is wrong, lost or late in them: datagrams_test.py. As net_test.py."""

import heapq
import json
import os
import pty
import random
import re
import select
import socket
import struct
import subprocess
import threading
import time
import unittest

import far_peer
from far_peer import WebSocket, hello, model, probes, row, welcome
from net_test import Case, Served, palpa, run, scene, slower, until

OFFER = struct.pack("<HBBIQ", 1, far_peer.DATAGRAMS, 0, 34, 0)
JUST_NOW_S = 0.2  # in which a datagram arrives on this machine, if it does


class Peer:
    """A hand of its own making, with a WebSocket and a UDP socket."""

    def __init__(self, served):
        self.web = WebSocket.client(served.port)
        self.web.send(hello(served.tokens["touch"]))
        offer = self.web.receive()[1]
        assert offer[:16] == OFFER and len(offer) == 34, offer
        self.key, self.port = offer[16:32], struct.unpack("<H", offer[32:])[0]
        assert self.web.receive()[1][2] == far_peer.WELCOME
        self.udp = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.number = 0

    def report(self):
        self.number += 1
        return probes(self.number, (0.0, 0.0, 0.1 - 1e-5 * self.number), self.number)

    def send(self, datagram):
        self.udp.sendto(datagram, ("127.0.0.1", self.port))

    def receive(self, limit_s=JUST_NOW_S, of=None):
        """The next datagram; None: there is none."""
        if not select.select([of or self.udp], [], [], limit_s * slower)[0]:
            return None
        return (of or self.udp).recv(65536)

    def web_kind(self, limit_s=JUST_NOW_S):
        """Kind of the next message of the WebSocket; None: there is none."""
        if not self.web.bytes and not select.select([self.web.connection], [], [], limit_s * slower)[0]:
            return None
        return self.web.receive()[1][2]

    def close(self):
        self.web.close()
        self.udp.close()


class Wrong(Case):
    def setUp(self):
        super().setUp()
        self.served = Served(self.folder, "--datagrams")
        self.addCleanup(self.served.end)
        self.peer = Peer(self.served)
        self.addCleanup(self.peer.close)

    def expect_alive(self):
        """Answers a ping, and a report by a model."""
        self.peer.send(self.peer.key)
        self.assertEqual(self.peer.receive(), self.peer.key)
        self.peer.send(self.peer.key + self.peer.report())
        answer = self.peer.receive()
        self.assertEqual((answer[:16], answer[18]), (self.peer.key, far_peer.MODEL))
        self.assertLessEqual(len(answer), 16 + 1400)
        while self.peer.receive(0.05):
            pass

    def expect_samples(self, count, least=None):
        self.peer.close()
        words = until(lambda: self.served.lines("has gone"))[0]
        self.assertIn(int(re.search(r"after (\d+) samples", words)[1]), range(least or count, count + 1))
        self.assertEqual(self.served.lines("refused"), [])

    def test_keys(self):
        for n in range(16):
            wrong = bytes(byte ^ (1 if at == n else 0) for at, byte in enumerate(self.peer.key))
            self.peer.send(wrong)
            self.peer.send(wrong + self.peer.report())
        self.peer.send(self.peer.key[:15])
        self.peer.send(b"")
        self.assertIsNone(self.peer.receive())
        self.expect_alive()
        self.expect_samples(1)

    def test_addresses(self):
        self.expect_alive()
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
            other.bind(("127.0.0.2", 0))
            for datagram in (self.peer.key, self.peer.key + self.peer.report()):
                other.sendto(datagram, ("127.0.0.1", self.peer.port))
            self.assertIsNone(self.peer.receive(of=other))
        self.expect_alive()

    def test_lengths(self):
        for length in (4097, 4096, 40000, 1):
            self.peer.send(self.peer.key + bytes(length))
        self.assertIsNone(self.peer.receive())
        self.expect_alive()
        self.expect_samples(1)

    def test_messages(self):
        report = self.peer.report()
        for wrong in (hello(self.served.tokens["touch"]), model(1, 1, (0, 0, 0), [row()]), report[:-1], OFFER + bytes(18), os.urandom(300),
                      report[:16] + b"\xff" * (len(report) - 16)):
            self.peer.send(self.peer.key + wrong)
        self.assertIsNone(self.peer.receive())
        self.assertIsNone(self.peer.web_kind())
        self.expect_alive()
        self.expect_samples(1)

    def test_again_and_in_any_order(self):
        reports = [self.peer.report() for _ in range(60)]
        for n, report in enumerate(reports):
            self.peer.send(self.peer.key + report)
            self.peer.send(self.peer.key + reports[random.Random(n).randrange(n + 1)])
            time.sleep(0.002)
        time.sleep(JUST_NOW_S)
        self.expect_samples(60, least=40)  # a busy machine may lose some, and must not feel any twice

    def test_a_flood(self):
        try:
            for _ in range(20000):
                self.peer.send(self.peer.key)
        except OSError:
            pass
        self.assertIn("2000 datagrams a second", self.peer.web.reason())

    def test_nothing_is_sent_to_where_nothing_came_from(self):
        self.peer.web.send(self.peer.report())
        self.assertEqual(self.peer.web_kind(), far_peer.MODEL)
        self.assertIsNone(self.peer.receive())
        self.expect_alive()
        self.peer.web.send(self.peer.report())  # the next answer goes the way that this came
        self.assertEqual(self.peer.web_kind(), far_peer.MODEL)
        self.assertIsNone(self.peer.receive())

    def test_the_port_is_taken(self):
        port = self.served.port
        self.served.end()
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
            other.bind(("127.0.0.1", port))
            self.expect_refusal(run("serve", scene, "--set", "volume.head.sampled=48", "--port", port, "--datagrams"), f"127.0.0.1:{port}",
                                "--datagrams")


class Proxy:
    """In front of a server: hands on the WebSocket, with another UDP port in its offer, and datagrams as `way` says: it gives the
    delay of each in s, or None for a lost one."""

    def __init__(self, port, way):
        self.port_there, self.way, self.heap, self.lost, self.ends = port, way, [], 0, False
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.udp = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(2)]  # to the hand, to the data
        for one in self.udp:
            one.bind(("127.0.0.1", 0))
        self.port, self.hand, self.data = self.listener.getsockname()[1], None, None
        self.pairs = {}
        self.thread = threading.Thread(target=self.work)
        self.thread.start()

    def work(self):
        while not self.ends:
            now = time.monotonic()
            while self.heap and self.heap[0][0] <= now:
                _, _, to_data, datagram = heapq.heappop(self.heap)
                self.udp[to_data].sendto(datagram, self.data if to_data else self.hand)
            wait_s = max(0.0, min(0.05, self.heap[0][0] - now)) if self.heap else 0.05
            for one in select.select([self.listener, *self.udp, *self.pairs], [], [], wait_s)[0]:
                if one is self.listener:
                    hand, there = one.accept()[0], socket.create_connection(("127.0.0.1", self.port_there))
                    for end in (hand, there):
                        end.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                    self.pairs[hand], self.pairs[there] = (there, False), (hand, True)
                elif one in self.udp:
                    self.delay(one)
                else:
                    self.hand_on(one)

    def hand_on(self, one):
        to, is_from_data = self.pairs[one]
        try:
            piece = one.recv(65536)
            at = piece.find(OFFER) if is_from_data else -1
            if at >= 0:
                self.data = ("127.0.0.1", struct.unpack("<H", piece[at + 32:at + 34])[0])
                piece = piece[:at + 32] + struct.pack("<H", self.udp[0].getsockname()[1]) + piece[at + 34:]
            if piece:
                return to.sendall(piece)
        except OSError:
            pass
        for end in (one, to):
            self.pairs.pop(end, None)
            end.close()

    def delay(self, one):
        datagram, address = one.recvfrom(65536)
        to_data = one is self.udp[0]
        if to_data:
            self.hand = address
        delay_s = self.way()
        if delay_s is None:
            self.lost += 1
        else:
            heapq.heappush(self.heap, (time.monotonic() + delay_s, id(datagram), to_data, datagram))

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.ends = True
        self.thread.join()
        for one in (self.listener, *self.udp, *self.pairs):
            one.close()


class Felt(Case):
    def feel(self, served, port=None, duration_s=2, more=("--datagrams",)):
        felt = run("run", scene, "--data-at", f"127.0.0.1:{port or served.port}", "--hand", "sim:press", "--device", "touch",
                   "--duration-s", duration_s, "--json", *more, token=served.tokens["touch"])
        self.assertEqual(felt.returncode, 0, felt.stderr)
        summary = json.loads(felt.stdout)
        self.assertGreater(summary["models"], 15 * duration_s)
        self.assertGreater(summary["largest_command_n"], 0.05)
        return summary

    def expect_replay(self, served):
        until(lambda: served.lines("has gone"))
        served.end()
        self.assertRegex(run("replay", self.folder / "traces").stdout, r"^hand-1: identical in all \d+ ticks\n$")

    def test_models_come_by_them(self):
        with Served(self.folder, "--datagrams", "--out", self.folder / "traces") as served:
            felt = self.feel(served, duration_s=3)
            self.assertGreater(felt["received_datagrams"], 0.9 * felt["models"])
            self.assertGreater(felt["sent_datagrams"], 0.6 * felt["ticks"])
            self.expect_replay(served)

    def test_only_where_both_sides_ask(self):
        for there, here in (((), ("--datagrams",)), (("--datagrams",), ())):
            with Served(self.folder, *there) as served:
                felt = self.feel(served, more=here)
                self.assertEqual((felt["sent_datagrams"], felt["received_datagrams"]), (0, 0))

    def test_loss_and_jitter(self):
        chance = random.Random(1)
        with Served(self.folder, "--datagrams", "--out", self.folder / "traces") as served:
            with Proxy(served.port, lambda: None if chance.random() < 0.02 else chance.uniform(0.003, 0.007)) as proxy:
                felt = self.feel(served, proxy.port, duration_s=4)
                self.assertGreater(proxy.lost, 20)
            self.assertGreater(felt["received_datagrams"], 100)
            self.assertGreater(felt["round_trip_ms"], 5.0)
            self.assertGreater(felt["link_up_ticks"], 0.9 * felt["ticks"], felt)
            self.expect_replay(served)

    def test_blocked_from_the_beginning(self):
        with Served(self.folder, "--datagrams") as served, Proxy(served.port, lambda: None) as proxy:
            felt = self.feel(served, proxy.port)
            self.assertGreater(proxy.lost, 10)
            self.assertEqual((felt["received_datagrams"], felt["sent_datagrams"]), (0, 0))
            self.assertGreater(felt["link_up_ticks"], 0.8 * felt["ticks"], felt)  # without waiting for datagrams

    def test_blocked_later(self):
        first_s = []

        def way():
            first_s.append(time.monotonic())
            return 0.001 if first_s[-1] - first_s[0] < 2.0 else None

        with Served(self.folder, "--datagrams") as served, Proxy(served.port, way) as proxy:
            felt = self.feel(served, proxy.port, duration_s=5)
        self.assertGreater(felt["received_datagrams"], 50)
        self.assertGreater(felt["models"], felt["received_datagrams"] + 50)
        self.assertGreaterEqual(felt["outages"], 1, felt)
        self.assertLess(felt["longest_outage_s"], 1.5 * slower)

    def test_hostile_data_bring_in_nothing_else(self):
        # A welcome of another scene would change the force; models alone are counted.
        listener, udp = socket.create_server(("127.0.0.1", 0)), socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.addCleanup(udp.close)
        udp.bind(("127.0.0.1", 0))
        key = os.urandom(16)
        wrong = key[:15] + bytes([key[15] ^ 1])

        def serve():
            try:
                peer = WebSocket.server(listener.accept()[0])
                peer.receive()
                for payload in (OFFER + key + struct.pack("<H", udp.getsockname()[1]), OFFER, OFFER[:5], welcome()):
                    peer.send(payload)
                while True:
                    datagram, hand = udp.recvfrom(65536)
                    self.assertEqual(datagram[:16], key)
                    if not datagram[16:]:
                        udp.sendto(key, hand)
                        continue
                    number, time_us = int.from_bytes(datagram[32:40], "little"), int.from_bytes(datagram[24:32], "little")
                    wrong_ones = (welcome(scene=2), welcome(scene=0), bytes(4097), os.urandom(50), OFFER + bytes(18))
                    for message in wrong_ones if number % 8 == 0 else ():
                        udp.sendto(key + message, hand)
                    udp.sendto(wrong + model(number, time_us, (0, 0, 0.02), []), hand)
                    udp.sendto(key + model(number, time_us, (0, 0, 0.01), [row(offset=(0, 0, 0.01))]), hand)
            except OSError:
                pass

        thread = threading.Thread(target=serve)
        thread.start()
        udp.settimeout(3)
        try:
            felt = run("run", "--data-at", f"127.0.0.1:{listener.getsockname()[1]}", "--hand", "sim:press", "--device", "touch",
                       "--duration-s", 2, "--json", "--datagrams", token="0" * 26)
        finally:
            listener.close()
            thread.join()
        self.assertEqual(felt.returncode, 0, felt.stderr)
        summary = json.loads(felt.stdout)
        self.assertGreater(summary["received_datagrams"], 500)
        self.assertLess(summary["received_datagrams"] - summary["models"], 20, summary)  # the last come after the last tick
        self.assertEqual(summary["outages"], 0)

    def test_the_lines_of_both_say_so(self):
        ours, theirs = pty.openpty()
        said = ""
        self.addCleanup(os.close, ours)
        with Served(self.folder, "--datagrams", stderr=theirs) as served:
            hand = subprocess.Popen([palpa, "run", "--data-at", f"127.0.0.1:{served.port}", "--hand", "sim:press", "--duration-s", "20",
                                     "--datagrams"], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=theirs,
                                    env={**os.environ, "PALPA_TOKEN": served.tokens["touch"]})
            try:
                end_s = time.monotonic() + 10 * slower
                while not ("link up by datagrams" in said and "ms away by datagrams" in said) and time.monotonic() < end_s:
                    if select.select([ours], [], [], 0.1)[0]:
                        said += os.read(ours, 65536).decode()
            finally:
                hand.kill()
                hand.wait()
            os.close(theirs)
        self.assertIn("link up by datagrams", said)
        self.assertIn("ms away by datagrams", said)


class Refused(Case):
    def test_what_would_be_encrypted_or_open(self):
        for arguments, piece in (
                (("serve", scene, "--datagrams", "--tls", "a.pem", "b.pem"), "--tls"),
                (("serve", scene, "--datagrams", "--listen", "0.0.0.0", "--token-file", self.folder / "tokens"), "--unencrypted"),
                (("run", "--data-at", "127.0.0.1:1", "--hand", "sim:press", "--datagrams", "--tls"), "--tls"),
                (("run", "--data-at", "127.0.0.1:1", "--hand", "sim:press", "--datagrams", "--ca", "a.pem"), "--ca"),
                (("run", "--data-at", "192.0.2.1:4711", "--hand", "sim:press", "--datagrams"), "--unencrypted"),
                (("run", scene, "--datagrams"), "--data-at")):
            self.expect_refusal(run(*arguments, token="0" * 26), "--datagrams" if piece != "--unencrypted" else piece, piece)


if __name__ == "__main__":
    unittest.main(verbosity=2, warnings="ignore")
