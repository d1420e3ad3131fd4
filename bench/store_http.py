#!/usr/bin/env python3
"""Share of ticks at octave 0, windows and bytes of a store that is felt live from an HTTP server with delays.

    python3 bench/store_http.py build/bench/bin/palpa FOLDER [SIDE [SECONDS [HAND]]]
"""

import json
import pathlib
import subprocess
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "tests/python"))
from store_server import served

scene = """palpa = 1
[coupling]
stiffness_n_per_m = 400
[volume.v]
file = "{store}"
memory_mb = 0.1
[workspace]
fit = "v"
[[mode]]
name = "surface"
type = "surface_and_friction"
field = "v"
[[mode.level]]
name = "wall"
value = 128
strength_n = 2
"""


def store_of(program, folder, side):
    """Two gyroids and noise, as bench_store has."""
    if (folder / "v.zarr").exists():
        return folder / "v.zarr"
    folder.mkdir(parents=True, exist_ok=True)
    j, i = (n.astype(np.float32) for n in np.ogrid[:side, :side])
    random = np.random.default_rng(1)
    with open(folder / "v.raw", "wb") as file:
        for k in np.arange(side, dtype=np.float32):
            turns = sum(weight * (np.sin(a * i) * np.cos(a * j) + np.sin(a * j) * np.cos(a * k) + np.sin(a * k) * np.cos(a * i))
                        for weight, a in ((40, 2 * np.pi / 80), (20, 2 * np.pi / 24)))
            (128 + turns + random.normal(0, 4, turns.shape)).clip(0, 255).astype(np.uint8).tofile(file)
    how = ["--set", "type=uint8", "--set", f"dims=[{side},{side},{side}]", "--set", "spacing_m=[1e-5,1e-5,1e-5]"]
    subprocess.run([program, "convert", folder / "v.raw", folder / "v.zarr", *how], check=True, capture_output=True)
    return folder / "v.zarr"


def felt(program, folder, store, seconds, hand):
    (folder / "s.toml").write_text(scene.format(store=store))
    done = subprocess.run([program, "run", folder / "s.toml", "--realtime", "--hand", hand, "--duration-s", str(seconds), "--json"],
                          capture_output=True, text=True)
    if done.returncode:
        sys.exit(done.stderr)
    return json.loads(done.stdout)


def main():
    program, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    side, seconds = (int(n) for n in (sys.argv[3:5] + ["256", "10"][len(sys.argv[3:5]):]))
    hand = sys.argv[5] if len(sys.argv) > 5 else "sim:stroke"
    store = store_of(program, folder, side)
    print("source      octave 0  raised at once  windows  lost  loading s  files  MB  at once")
    for delay_ms in (None, 0, 20, 50, 100):
        with served(store.parent, delay_s=(delay_ms or 0) / 1000) as server:
            said = felt(program, folder, store if delay_ms is None else server.url(store.name), seconds, hand)
        octaves, windows = said["felt_octaves"], said["loop"]["windows"]
        name = "folder" if delay_ms is None else f"HTTP {delay_ms} ms"
        print(f"{name:<10}  {100 * octaves['finest_share']:7.1f}%  {100 * octaves['forced_ticks'] / said['ticks']:13.2f}%  {windows['made']:7}  "
              f"{windows['lost']:4}  {windows['busy_s']:9.2f}  {len(server.requests):5}  {server.bytes / 1e6:.1f}  {server.most_at_once}")


if __name__ == "__main__":
    main()
