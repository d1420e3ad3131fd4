"""Builds the wheel for pip (PEP 517). Needs the library's dependencies, pybind11-dev and CMake, and no network.

The wheel holds only the package and the library: files other than raw numbers are opened by palpa-read, of the package palpa
or at $PALPA_READER.
"""

import base64
import hashlib
import os
import pathlib
import re
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import zipfile

source = pathlib.Path(__file__).resolve().parents[1]


def _version():
    return re.search(r"project\(palpa VERSION ([0-9.]+)", (source / "CMakeLists.txt").read_text())[1]


def _numpy():
    """Required numpy versions: pybind11 supports numpy 2 from its version 2.12 on."""
    version = re.search(r'pybind11 = "(\d+)\.(\d+)', (source / "build/wheel/python/palpa/_version.py").read_text())
    return "numpy>=1.24" if tuple(map(int, version.groups())) >= (2, 12) else "numpy>=1.24,<2"


def _installed(tree):
    """Builds the package with its library and installs it into a folder."""
    build = source / "build/wheel"
    settings = dict(CMAKE_BUILD_TYPE="Release", CMAKE_INSTALL_PREFIX="/wheel", CMAKE_INSTALL_LIBDIR="palpa/lib",
                    PALPA_PYTHON_FOLDER=".", PALPA_PYTHON="ON", PALPA_INSTALL="ON",
                    PALPA_READER="OFF", PALPA_APP="OFF", PALPA_VIEW="OFF", PALPA_DEVICES="OFF", PALPA_EXAMPLES="OFF",
                    PALPA_TESTS="OFF")
    # Built by Debian's Python, which has numpy, even if pip's environment has not.
    subprocess.run(["cmake", "-G", "Ninja", "-S", source, "-B", build, *[f"-D{key}={value}" for key, value in settings.items()]],
                   check=True)
    subprocess.run(["cmake", "--build", build, "--target", "palpa_python_types", "palpa_core"], check=True)
    for component in ("library", "python"):
        subprocess.run(["cmake", "--install", build, "--prefix", tree, "--component", component, "--strip"], check=True)
    if not (tree / "palpa" / f"_palpa{sysconfig.get_config_var('EXT_SUFFIX')}").exists():
        raise RuntimeError(f"palpa: the module is made for Debian's Python, and pip runs in {sys.version.split()[0]}; use that one's")
    for link in [path for path in tree.rglob("*") if path.is_symlink()]:  # wheels have no links: keep one file, by its requested name
        target = link.resolve()
        link.unlink()
        if not target.is_symlink() and target.exists():
            target.rename(link)


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    platform = sysconfig.get_platform().replace("-", "_").replace(".", "_")
    version = _version()
    name = f"palpa-{version}-{python}-{python}-{platform}.whl"
    information = f"palpa-{version}.dist-info"
    with tempfile.TemporaryDirectory() as folder:
        tree = pathlib.Path(folder)
        _installed(tree)
        (tree / information).mkdir()
        shutil.copy(source / "LICENSE", tree / information)
        (tree / information / "METADATA").write_text(
            f"Metadata-Version: 2.1\nName: palpa\nVersion: {version}\nSummary: Touch volumetric data\nLicense: Apache-2.0\n"
            f"Requires-Python: >=3.11\nRequires-Dist: {_numpy()}\n")
        (tree / information / "WHEEL").write_text(
            f"Wheel-Version: 1.0\nGenerator: palpa\nRoot-Is-Purelib: false\nTag: {python}-{python}-{platform}\n")
        record = []
        with zipfile.ZipFile(pathlib.Path(wheel_directory) / name, "w", zipfile.ZIP_DEFLATED) as wheel:
            for path in sorted(tree.rglob("*")):
                if not path.is_file():
                    continue
                inside, data = path.relative_to(tree).as_posix(), path.read_bytes()
                digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
                record.append(f"{inside},sha256={digest},{len(data)}\n")
                wheel.write(path, inside)
            record.append(f"{information}/RECORD,,\n")
            wheel.writestr(f"{information}/RECORD", "".join(record))
    return name


def get_requires_for_build_wheel(config_settings=None):
    return []
