"""Classes generated from the parameter lists that scene files are read by."""

import inspect
from collections.abc import Mapping

from . import _palpa


class Strict:
    """Has only the attributes of its class: setting any other raises AttributeError."""

    _elsewhere = ()  # (holder, names): attributes of its parts, for suggestions

    def __setattr__(self, name, value):
        of_class = getattr(type(self), name, None)
        if callable(of_class) and not name.startswith("_"):
            raise AttributeError(f"{type(self).__name__}: {name!r} is a method, which cannot be set; call it: {name}()")
        if not (name.startswith("_") or hasattr(of_class, "__set__") or name in getattr(type(self), "__annotations__", ())):
            raise AttributeError(self._unknown(name))
        object.__setattr__(self, name, value)

    def _unknown(self, name):
        return f"{type(self).__name__}: no attribute {name!r}; {_there_are(name, self._names(), self._elsewhere)}"

    def _names(self):
        return [name for name in (*dir(type(self)), *getattr(type(self), "__annotations__", ())) if not name.startswith("_")]


def say_what_cannot_be_set(cls):
    """Gives a C++ class one-sentence errors for attributes that cannot be set."""

    def __setattr__(self, name, value):
        try:
            object.__setattr__(self, name, value)
        except AttributeError:
            of_class = getattr(cls, name, None)
            if of_class is None:
                why = f"no attribute {name!r}; " + _there_are(name, [each for each in dir(cls) if not each.startswith("_")])
            else:
                why = f"{name!r} " + (f"is a method, which cannot be set; call it: {name}()" if callable(of_class) else "cannot be set")
            raise AttributeError(f"{cls.__name__}: {why}") from None

    cls.__setattr__ = __setattr__


class Parameters:
    """Object with a list of parameters: attributes with the names, units and defaults of C++ and scene files."""

    __slots__ = ("_part",)
    _keys = ()

    def __init_subclass__(cls, **given):
        if "_keys" not in vars(cls):
            base = next(each.__name__ for each in cls.__mro__ if "_keys" in vars(each))
            raise TypeError(f"{cls.__name__}: {base} is made in C++, and nothing in Python changes what it does; a mode of your own "
                            "derives from palpa.Mode")
        super().__init_subclass__(**given)

    @classmethod
    def _of(cls, part):
        made = object.__new__(cls)
        object.__setattr__(made, "_part", part)
        return made

    def _fill(self, values):
        for name, value in values.items():
            if name not in type(self)._attributes:
                raise TypeError(f"{type(self).__name__}: no parameter {name!r}; {_there_are(name, type(self)._attributes)}")
            setattr(self, name, value)

    def _values(self):
        return {name: getattr(self, name) for name in type(self)._attributes}

    def __setattr__(self, name, value):
        if name not in type(self)._attributes and name != "_part":
            raise AttributeError(f"{type(self).__name__}: no parameter {name!r}; {_there_are(name, type(self)._attributes)}")
        object.__setattr__(self, name, value)

    def __eq__(self, other):
        if type(self) is not type(other):
            return NotImplemented
        return self._values() == other._values()

    __hash__ = None

    def __repr__(self):
        defaults = type(self)._defaults
        said = [f"{name}={value!r}" for name, value in self._values().items() if value != defaults[name]]
        return f"{type(self).__qualname__}({', '.join(said)})"

    def __copy__(self):
        return type(self)(**self._values())

    def __deepcopy__(self, memo):
        return self.__copy__()

    def __reduce__(self):
        return _made_of, (type(self), self._values())


def _made_of(cls, values):
    return cls(**values)


def _there_are(name, names, elsewhere=()):
    import difflib

    for holder, theirs in elsewhere:
        if name in theirs:
            return f"did you mean '{holder}.{name}'?"
    near = difflib.get_close_matches(name, names, 1)
    return f"did you mean {near[0]!r}?" if near else "there are: " + ", ".join(names)


class Named(Mapping):
    """Read-only mapping by name; a missing name raises KeyError with the closest name."""

    def __init__(self, of, kind, things):
        self._of, self._kind, self._things = of, kind, dict(things)

    def __getitem__(self, name):
        try:
            return self._things[name]
        except (KeyError, TypeError):
            raise KeyError(_Sentence(f"{self._of} has no {self._kind} {name!r}; "
                                     f"{_there_are(str(name), list(self._things)) if self._things else 'it has none'}")) from None

    def __iter__(self):
        return iter(self._things)

    def __len__(self):
        return len(self._things)

    def __repr__(self):
        return repr(self._things)


class _Sentence(str):
    """Text that KeyError prints without quotes."""

    def __repr__(self):
        return str(self)


def _attribute_of(key):
    """Attribute of a key: the plural for a list, as in C++: [[mode.level]] is `levels`."""
    name, annotation = key[0], key[1]
    return name + "s" if annotation == "list" else name


def _property_of(key, item_class, annotation):
    name, _, form, _, sentence, _ = key

    def get(self):
        value = self._part.get(name)
        return tuple(item_class._of(part) for part in value) if item_class else value

    def put(self, value):
        try:
            if item_class and value is not None:
                value = [item._part if isinstance(item, Parameters) else item for item in value]
            self._part.set(name, value)
        except (TypeError, ValueError, AttributeError) as error:
            raise type(error)(f"{type(self).__qualname__}: {error}") from None

    return property(get, put, doc=f"{annotation}: {sentence} ({form})")


def make_class(name, base, summary, keys, new_part, module="palpa", qualname=None):
    """Class with a property for each key, keyword arguments and a docstring.

    new_part() returns a part with the defaults.
    """
    qualname = qualname or name
    namespace = {"__slots__": (), "__module__": module, "__qualname__": qualname, "_keys": keys}
    item_classes = {}
    for key in keys:
        if key[5]:
            item = key[0].capitalize()
            item_classes[key[0]] = namespace[item] = make_class(
                item, Parameters, f"One of the `{_attribute_of(key)}` of {qualname}.", key[5],
                lambda list_name=key[0]: _palpa.new_item(new_part(), list_name), module, f"{qualname}.{item}")
    lines = [summary, ""]
    for key in keys:
        attribute, item_class = _attribute_of(key), item_classes.get(key[0])
        annotation = f"Sequence[{item_class.__qualname__}]" if item_class else key[1]
        namespace[attribute] = _property_of(key, item_class, annotation)
        default = key[3] or "none"
        lines += [f"{attribute} : {annotation}", f"    {key[4]}",
                  f"    ({key[2]}; {'required' if default == 'required' else 'default: ' + default})"]
    namespace["_attributes"] = tuple(_attribute_of(key) for key in keys)
    namespace["__doc__"] = "\n".join(lines)

    def __init__(self, **parameters):
        object.__setattr__(self, "_part", new_part())
        self._fill(parameters)

    __init__.__qualname__ = f"{qualname}.__init__"
    namespace["__init__"] = __init__
    cls = type(name, (base,), namespace)
    fresh = cls()
    cls._defaults = {attribute: getattr(fresh, attribute) for attribute in cls._attributes}
    cls.__signature__ = inspect.Signature([
        inspect.Parameter(attribute, inspect.Parameter.KEYWORD_ONLY, default=cls._defaults[attribute])
        for attribute in cls._attributes])
    return cls


def class_name(mode_type):
    """follow → Follow, surface_and_friction → SurfaceAndFriction, lab.ridge → LabRidge."""
    return "".join(word.capitalize() for word in mode_type.replace(".", "_").replace("-", "_").split("_"))
