"""Numbers from Python are independent of a locale with a decimal comma."""

import ctypes
import locale
import struct

import pytest

import palpa

scene_text = """palpa = 1
[coupling]
stiffness_n_per_m = 612.5
[volume.v]
analytic = "head_phantom"
[[mode]]
name = "skin"
type = "surface_and_friction"
field = "v"
[[mode.level]]
value = -300.5
strength_n = 0.75
[[mode.level]]
value = 300.5
name = "bone"
strength_n = 4.25
"""


@pytest.fixture
def comma(tmp_path, monkeypatch):
    """The locale "comma" for LC_NUMERIC in glibc's format, so that no machine need have one."""
    data, offsets, head = b"", [], 8 + 4 * 6
    for text in (b",", b".", b"\3"):
        offsets.append(head + len(data))
        data += text + b"\0"
    data += b"\0" * (-(head + len(data)) % 4)
    for letter in ",.":
        offsets.append(head + len(data))
        data += struct.pack("=I", ord(letter))
    offsets.append(head + len(data))
    data += b"UTF-8\0"
    folder = tmp_path / "locales" / "comma"
    folder.mkdir(parents=True)
    (folder / "LC_NUMERIC").write_bytes(struct.pack("=2I", 0x20031115 ^ 1, 6) + struct.pack("=6I", *offsets) + data)
    monkeypatch.setenv("LOCPATH", str(tmp_path / "locales"))

    def begin():
        locale.setlocale(locale.LC_NUMERIC, "comma")
        text = ctypes.create_string_buffer(16)
        ctypes.CDLL(None).snprintf(text, 16, b"%.1f", ctypes.c_double(1.5))
        assert text.value == b"1,5"

    yield begin
    locale.setlocale(locale.LC_NUMERIC, "C")


def made(folder):
    """All text and files that leave Python."""
    (folder / "scene.toml").write_text(scene_text)
    trace = palpa.run(folder / "scene.toml", "sim:stroke,depth_m=0.0125", duration_s=1.25, out=folder / "trace", primitives=True)
    files = {path.name: path.read_bytes() for path in trace.folder.iterdir() if path.name not in ("timing.csv", "trace.toml")}
    scene = palpa.load_scene(folder / "scene.toml")
    return files | {"scene": scene.to_toml(), "notes": trace.header["notes"], "force": trace.summary["force_max_n"],
                    "ticks": trace.ticks["force_n"].tolist()}


@pytest.mark.filterwarnings("ignore:The level bone:palpa.PalpaWarning")
def test_a_comma_changes_nothing(tmp_path, comma):
    (tmp_path / "classic").mkdir()
    (tmp_path / "commas").mkdir()
    classic = made(tmp_path / "classic")
    assert classic["force"] > 0.1 and "4.25 N" in classic["notes"][0]
    comma()
    assert made(tmp_path / "commas") == classic
