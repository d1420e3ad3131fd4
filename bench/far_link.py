#!/usr/bin/env python3
"""Force of a far hand beside the undelayed session, over sockets: far_link.py PALPA SCENE HAND SECONDS [LINK…]

For each LINK, as delay_ms=5,jitter_ms=2,loss=0.01, serves SCENE, feels it with HAND through that link, and prints a row: error
of the force, root mean square and 99th percentile, between the session that got the samples and what the hand's motors got.
"""

import csv
import json
import os
import re
import signal
import subprocess
import sys
import tempfile
import time


def vector(row, *names):
    return [float(row[name]) for name in names]


def errors_n(trace):
    """|command − session's| of each sample that the guard passed, and the largest of the session's."""
    session = {}
    for row in csv.DictReader(open(f"{trace}/ticks.csv")):
        session[int(row["tick"])] = vector(row, "command_x_n", "command_y_n", "command_z_n")
    errors, largest_n, group = [], 0.0, []
    for row in [*csv.DictReader(open(f"{trace}/hand.csv")), None]:
        if group and (row is None or row["sample"] != group[-1]["sample"]):
            # A report has the command of the tick before its newest sample.
            last, before = group[-1], int(group[-1]["tick"]) - 1
            if before in session and last["guard"] in ("pass", "limited"):
                felt, true = vector(last, "command_x_n", "command_y_n", "command_z_n"), session[before]
                errors.append(sum((a - b) ** 2 for a, b in zip(felt, true)) ** 0.5)
                largest_n = max(largest_n, sum(a * a for a in true) ** 0.5)
            group = []
        group.append(row)
    return errors, largest_n


def felt_through(palpa, scene, hand, seconds, link):
    with tempfile.TemporaryDirectory() as folder:
        with open(f"{folder}/out", "w") as out:
            server = subprocess.Popen([palpa, "serve", scene, "--port", "0", "--out", f"{folder}/traces"], stdout=out,
                                      stderr=subprocess.DEVNULL, stdin=subprocess.DEVNULL)
        while not (said := re.search(r"come to (\S+) .*touch (\S+)", open(f"{folder}/out").read(), re.S)):
            time.sleep(0.1)
        felt = subprocess.run([palpa, "run", scene, "--data-at", said[1], "--hand", hand, "--duration-s", seconds, "--json", "--far-anyway",
                               *(["--link", link] if link else [])], env={**os.environ, "PALPA_TOKEN": said[2]}, stdin=subprocess.DEVNULL,
                              stdout=subprocess.PIPE, text=True, check=True)
        time.sleep(0.5)
        server.send_signal(signal.SIGINT)
        server.wait()
        return json.loads(felt.stdout), *errors_n(f"{folder}/traces/hand-1")


def main():
    palpa, scene, hand, seconds, *links = sys.argv[1:]
    print("| link | error RMS / p99 / N | largest / N | round trip / ms | models/s | kB/s there, back | missed | outages |")
    print("|---|---|---|---|---|---|---|---|")
    for link in links or [""]:
        summary, errors, largest_n = felt_through(palpa, scene, hand, seconds, link)
        rms_n = (sum(error * error for error in errors) / len(errors)) ** 0.5
        print(f"| {link or 'loopback'} | {rms_n:.3f} / {sorted(errors)[int(0.99 * len(errors))]:.3f} | {largest_n:.2f} "
              f"| {summary['round_trip_ms']:.1f} | {summary['models_per_s']:.0f} "
              f"| {summary['sent_bytes_per_s'] / 1e3:.0f}, {summary['received_bytes_per_s'] / 1e3:.0f} "
              f"| {summary['missed']} of {summary['ticks'] + summary['missed']} | {summary['outages']} |", flush=True)


if __name__ == "__main__":
    main()
