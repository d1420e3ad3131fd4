#!/usr/bin/env python3
"""The table of docs/check.md: nine scenes with real data on four devices, as `palpa check` finds them.

  check_scenes.py PALPA DATA_FOLDER [DEVICE...]
"""
import json
import pathlib
import subprocess
import sys
import tempfile
import time

SHIPPED = ["head", "many", "wing", "flow"]
SUGGESTED = {
    "vessels": "mra_avf_nrrd/avf_float_32.nrrd",
    "storm": "weather_isabel/isabel_30.vti",
    "brain": "mri_flair_nrrd/FLAIR.nrrd",
    "protein": "mol_ironprot/ironProt.vtk",
    "combustor": "cfd_combustor/combxyz.bin",
}
SCENES = pathlib.Path(__file__).resolve().parent.parent / "scenes"


def main() -> int:
    if len(sys.argv) < 3:
        print(__doc__, file=sys.stderr)
        return 2
    palpa, data = sys.argv[1], pathlib.Path(sys.argv[2]).resolve()
    devices = sys.argv[3:] or ["touch", "omega", "falcon", "inverse3"]
    print("| scene | device | verdict | reason | change | then | seconds |\n|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        scenes = {name: SCENES / f"{name}.toml" for name in SHIPPED}
        for name, file in SUGGESTED.items():
            scenes[name] = pathlib.Path(folder) / f"{name}.toml"
            subprocess.run([palpa, "info", data / file, "--scene", scenes[name]], check=True, capture_output=True)
        for name, scene in scenes.items():
            for device in devices:
                begin = time.monotonic()
                done = subprocess.run([palpa, "check", scene, "--device", device, "--data", data, "--json"],
                                      capture_output=True, text=True)
                seconds = time.monotonic() - begin
                if done.returncode not in (0, 1):
                    raise SystemExit(done.stderr)
                report = json.loads(done.stdout)
                reason = report["reason"].split(": ", 1)[1]
                changes = ", ".join(f"{c['path'].split('.')[1]} {c['from']:g} to {c['to']:g}" for c in report["changes"])
                then = report["verdict_after_changes"] if changes else "-"
                print(f"| {name} | {device} | {report['verdict']} | {reason} | {changes or '-'} | {then} | {seconds:.0f} |", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
