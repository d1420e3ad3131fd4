"""Stores at a web address, felt through windows: the same bits as from a folder, and no harm by a bad server."""

import json
import os
import pathlib
import shutil
import subprocess
import threading
import time

import pytest

zarr = pytest.importorskip("zarr", reason="python3-zarr is not installed")

from store_server import Answer, certificate, served
from stores import felt, palpa_run, prepared, run_on


@pytest.fixture(autouse=True)
def needs_fetch():
    if not (pathlib.Path(os.environ["PALPA_BIN"]) / "palpa-fetch").exists():
        pytest.skip("palpa-fetch is not built: libcurl is missing")


@pytest.fixture(scope="module")
def hand(prepared, tmp_path_factory):
    folder = tmp_path_factory.mktemp("hand")
    run_on(pathlib.Path(os.environ["PALPA_BIN"]) / "palpa", folder, prepared("uint8"), 1000, "placed")
    return folder / "placed" / "ticks.csv"


def refused(program, *arguments, status=2, **more):
    """The one line of a command that ends with an error."""
    done = palpa_run(program, *arguments, **more)
    assert done.returncode == status and done.stderr.count("\n") == 1, (done.returncode, done.stdout, done.stderr)
    return done.stderr


@pytest.mark.parametrize("version", "23")
def test_the_same_bits_as_from_a_folder(version, prepared, hand, tmp_path, palpa_program):
    store = prepared("uint8", *(["--zarr", "3"] if version == "3" else []))
    here = run_on(palpa_program, tmp_path, store, 1, "here", hand)
    with served(store.parent) as server:
        assert run_on(palpa_program, tmp_path, server.url(store.name), 1, "there", hand) == here
        assert len(here["ticks.csv"].splitlines()) > 900
        assert len(server.requests) > 50 and server.most_at_once <= 32 and server.connections <= 6 * 32
        again = palpa_run(palpa_program, "replay", tmp_path / "there")
        assert again.returncode == 0 and "identical in all 1000 ticks" in again.stdout, again.stdout + again.stderr
        whole = run_on(palpa_program, tmp_path, server.url(store.name + "/"), 1000, "whole", hand)
        assert whole == here


def test_a_server_without_parts_gives_small_shards_as_a_whole(prepared, hand, tmp_path, palpa_program):
    store = prepared("uint8", "--zarr", "3")
    here = run_on(palpa_program, tmp_path, store, 1, "here", hand)
    with served(store.parent, gives_parts=False) as server:
        assert run_on(palpa_program, tmp_path, server.url(store.name), 1, "there", hand) == here


def test_an_absent_chunk_is_as_in_a_folder(prepared, hand, tmp_path, palpa_program):
    store = tmp_path / "v.zarr"
    shutil.copytree(prepared("uint8"), store)
    chunks = sorted(path for path in (store / "0").rglob("*") if path.is_file() and path.name.isdigit())
    for chunk in chunks[::3]:
        chunk.unlink()
    here = run_on(palpa_program, tmp_path, store, 1, "here", hand)
    with served(tmp_path) as server:
        assert run_on(palpa_program, tmp_path, server.url("v.zarr"), 1, "there", hand) == here
        shutil.rmtree(store / "palpa")  # not prepared: the next octave says that they are lost
        here = run_on(palpa_program, tmp_path, store, 1, "bare", hand)
        assert run_on(palpa_program, tmp_path, server.url("v.zarr"), 1, "bare_there", hand) == here


def test_info_check_and_first_scene_of_an_address(prepared, tmp_path, palpa_program):
    store = prepared("uint8")
    with served(store.parent) as server:
        url = server.url(store.name)
        here = json.loads(palpa_run(palpa_program, "info", store, "--set", "memory_mb=1", "--json").stdout)["store"]
        there = json.loads(palpa_run(palpa_program, "info", url, "--json").stdout)["store"]
        done = palpa_run(palpa_program, "info", url, "--scene", tmp_path / "first.toml")
        assert done.returncode == 0, done.stderr
        for key in ("fields", "octaves", "prepared", "format"):
            assert there[key] == here[key]
        assert "not looked for: by HTTP" in palpa_run(palpa_program, "info", url).stdout
        text = (tmp_path / "first.toml").read_text()
        assert f'file = "{url}"' in text
        check = palpa_run(palpa_program, "check", tmp_path / "first.toml", "--device", "omega")
        assert "octaves    " in check.stdout, check.stdout + check.stderr
        run = palpa_run(palpa_program, "run", tmp_path / "first.toml", "--hand", "sim:stroke", "--duration-s", "0.3")
        assert run.returncode == 0 and "in contact" in run.stdout, run.stderr


def test_only_reading_is_by_http(tmp_path, palpa_program):
    (tmp_path / "v.raw").write_bytes(bytes(1000))
    url = "http://127.0.0.1:1/v.zarr"
    how = ("--set", "type=uint8", "--set", "dims=[10,10,10]", "--set", "spacing_m=[1e-3,1e-3,1e-3]")
    assert "reading alone; palpa convert takes a folder" in refused(palpa_program, "convert", tmp_path / "v.raw", url, *how)
    assert "reading alone; palpa prepare takes a folder" in refused(palpa_program, "prepare", url)
    assert "reading alone; palpa prepare takes a folder" in refused(palpa_program, "prepare", url, "--derive", "curl=v")
    assert not (tmp_path / "http:").exists()


@pytest.mark.parametrize("address, words", [
    ("http://127.0.0.1:1/v.zarr", "cannot be reached"),
    ("http://me:secret@127.0.0.1:1/v.zarr", "names a user"),
    ("http://127.0.0.1:1/v.zarr?key=1", "has a query or a fragment"),
    ("http://127.0.0.1:1/a/../v.zarr", "has a '..'"),
    ("http:///v.zarr", "names no server"),
    ("http://127.0.0.1:1/my v.zarr", "has a blank"),
])
def test_addresses_that_cannot_be_fetched(address, words, tmp_path, palpa_program):
    assert words in refused(palpa_program, "info", address)
    (tmp_path / "s.toml").write_text(felt.format(store=address, memory_mb=1, value=140))
    assert words in refused(palpa_program, "run", tmp_path / "s.toml", "--hand", "sim:stroke")


def metadata(**answer):
    """A fault of the metadata alone."""
    return lambda name: Answer(**answer) if name.endswith((".zattrs", "zarr.json", ".zarray", ".zgroup")) else None


@pytest.mark.parametrize("fault, words", [
    (dict(status=302, headers={"Location": "file:///etc/passwd"}, body=b""), "leads to 'file:///etc/passwd', which is not followed"),
    (dict(status=301, headers={"Location": "http://127.0.0.1:1/"}, body=b""), "leads to 'http://127.0.0.1:1/', which is not followed"),
    (dict(says_bytes=10**13), "longer than any sound one"),
    (dict(body=b"{" + b" " * (5 << 20), headers={"Connection": "close"}), "longer than any sound one"),
    (dict(says_bytes=5000, ends_after=3), "was cut short by its server"),
    (dict(body=b"", headers={f"X-{n}": "x" * 900 for n in range(100)}), "cannot be fetched"),
    (dict(status=503, body=b"later"), "answers 503"),
    (dict(status=403, body=b""), "has no metadata of Zarr (the server answers 403, forbidden"),
    (dict(status=404, body=b""), "has no metadata of Zarr"),
    (dict(body=b"x", headers={"Content-Encoding": "gzip"}), "is packed by its server"),
    (dict(body=b"not JSON"), "that is no JSON object"),
])
def test_hostile_metadata_are_one_line(fault, words, prepared, palpa_program):
    store = prepared("uint8")
    with served(store.parent, fault=metadata(**fault)) as server:
        assert words in refused(palpa_program, "info", server.url(store.name))


def chunks(**answer):
    """A fault of the chunks of octave 0."""
    return lambda name: Answer(**answer) if name.split("/")[1] == "0" and name[-1].isdigit() else None


@pytest.mark.parametrize("fault, words", [
    (dict(ends_after=100), "was cut short by its server"),
    (dict(says_bytes=10**13), "is longer than any sound one"),
    (dict(status=500, body=b"no"), "its server answers 500"),
    (dict(status=302, headers={"Location": "file:///etc/passwd"}, body=b""), "not followed"),
    (dict(body=b"damage"), "of octave 0 is damaged"),
])
def test_a_chunk_that_cannot_be_fetched_leaves_the_coarser_octave(fault, words, prepared, hand, tmp_path, palpa_program):
    store = prepared("uint8")
    scene = tmp_path / "s.toml"
    with served(store.parent, fault=chunks(**fault)) as server:
        scene.write_text(felt.format(store=server.url(store.name), memory_mb=1, value=140))
        run = palpa_run(palpa_program, "run", scene, "--hand", hand, "--duration-s", "0.02", "--out", tmp_path / "out")
        assert run.returncode == 0 and words in run.stderr and "coarser octaves are felt there" in run.stderr, run.stderr
    assert {row.split(",")[-2] for row in (tmp_path / "out/ticks.csv").read_text().splitlines()[1:]} != {"0"}


def test_certificates_are_checked(prepared, hand, tmp_path, palpa_program):
    store = prepared("uint8")
    files = certificate(tmp_path)
    with served(store.parent, tls=files) as server:
        url = server.url(store.name, host="localhost")
        assert "the certificate of its server is not accepted" in refused(palpa_program, "info", url)
        known = {**os.environ, "SSL_CERT_FILE": str(files[0])}
        done = palpa_run(palpa_program, "info", url, env=known)
        assert done.returncode == 0 and "OME-Zarr" in done.stdout, done.stderr
        other = server.url(store.name)  # a name that the certificate has not
        assert "the certificate of its server is not accepted" in refused(palpa_program, "info", other, env=known)


def live(program, folder, url, out, seconds=2.0):
    scene = folder / f"{out}.toml"
    scene.write_text(felt.format(store=url, memory_mb=1, value=140))
    return ["run", scene, "--realtime", "--hand", "sim:stroke", "--duration-s", seconds, "--out", folder / out, "--json"]


def test_a_slow_server_live_and_again_to_the_bit(prepared, tmp_path, palpa_program):
    store = prepared("uint8")
    with served(store.parent, delay_s=0.04) as server:
        done = palpa_run(palpa_program, *live(palpa_program, tmp_path, server.url(store.name), "live"))
        assert done.returncode == 0, done.stderr
        said = json.loads(done.stdout)
        assert said["loop"]["windows"]["made"] > 0 and said["loop"]["windows"]["lost"] == 0
        assert said["felt_octaves"]["finest_share"] > 0.1
        server.delay_s = 0.0
        again = palpa_run(palpa_program, "replay", tmp_path / "live")
        assert again.returncode == 0 and "identical in all" in again.stdout, again.stdout + again.stderr


def test_a_server_that_dies_leaves_what_is_in_memory(prepared, tmp_path, palpa_program):
    store = prepared("uint8")
    with served(store.parent) as server:
        port, url = server.server_port, server.url(store.name)
        arguments = live(palpa_program, tmp_path, url, "live", 3.0)
        run = subprocess.Popen([palpa_program, *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        time.sleep(1.5)
        server.fault = lambda name: Answer(ends_after=0)
        threading.Thread(target=server.shutdown).start()
        out, said = run.communicate(timeout=60)
    assert run.returncode == 0 and json.loads(out)["ticks"] > 2000, said
    with served(store.parent, port=port):
        again = palpa_run(palpa_program, "replay", tmp_path / "live")
    assert again.returncode == 0 and "identical in all" in again.stdout, again.stdout + again.stderr
