"""Names of 0.1, each read with a warning that holds the new name (docs/changes.md)."""

import warnings

from ._parameters import _there_are
from ._scene import PalpaWarning


def _warn(old, new):
    warnings.warn(f"{old} is called {new} now", PalpaWarning, stacklevel=3)


def keep_old_names(cls, **renamed):
    """Gives a class the names that its attributes had, and one-sentence errors for unknown ones."""

    def __getattr__(self, name):
        if name not in renamed:
            there = [each for each in dir(cls) if not each.startswith("_")]
            raise AttributeError(f"{cls.__name__}: no attribute {name!r}; {_there_are(name, there)}")
        _warn(f"{cls.__name__}.{name}", renamed[name])
        return getattr(self, renamed[name])

    cls.__getattr__ = __getattr__


def old_names_of(module, **renamed):
    """A module's __getattr__ for names that its classes had."""

    def __getattr__(name):
        if name not in renamed:
            raise AttributeError(f"module '{module.__name__}' has no attribute '{name}'")
        _warn(f"{module.__name__}.{name}", renamed[name])
        return getattr(module, renamed[name])

    return __getattr__
