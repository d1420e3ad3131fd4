"""The sources of the library in C++. In the root of a checkout `import palpa` finds this folder first; the Python package, which
is built from ../python, takes its place: that of PYTHONPATH or of the installation, else that of the newest build folder.
"""

import importlib.machinery
import importlib.util
import pathlib
import sys

_root = pathlib.Path(__file__).resolve().parents[1]


def _leads_back(folder):
    """A checkout: this one, or another whose module would come back here."""
    return folder.resolve() == _root or (folder / "palpa/palpa.h").exists()


_installed = [folder for folder in sys.path if not _leads_back(pathlib.Path(folder))]
_built = sorted({module.parents[1] for module in _root.glob("build/*/python/palpa/_palpa.*")},
                key=lambda folder: (folder / "palpa").stat().st_mtime, reverse=True)
_spec = importlib.machinery.PathFinder.find_spec("palpa", [*_installed, *map(str, _built)])
if _spec is None or _spec.origin is None:
    raise ImportError(f"palpa: {_root / 'palpa'} holds the sources in C++, and the Python package is not built; cmake --preset release "
                      "-DPALPA_PYTHON=ON && cmake --build build/release --target palpa_python_types builds it "
                      "(docs/python.md)", name="palpa")
_package = importlib.util.module_from_spec(_spec)
sys.modules["palpa"] = _package
_spec.loader.exec_module(_package)
