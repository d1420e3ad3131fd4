"""Sliders of ipywidgets on a live scene."""

from __future__ import annotations

from typing import Any

from ._parameters import Parameters


def _numbers_of(part, place):
    """(place, part, attribute) of each number of a part, and of the items of its lists."""
    for attribute in type(part)._attributes:
        value = getattr(part, attribute)
        if isinstance(value, float):
            yield f"{place}.{attribute}", part, attribute
        elif isinstance(value, tuple):
            for n, item in enumerate(value):
                if isinstance(item, Parameters):
                    yield from _numbers_of(item, f"{place}.{attribute}[{n}]")


def _all_numbers(scene):
    """{place: (part, attribute)} of a scene: "coupling.stiffness_n_per_m", "skin.levels[0].strength_n", …"""
    found = list(_numbers_of(scene.coupling, "coupling")) + list(_numbers_of(scene.workspace, "workspace"))
    for name, mode in scene.modes.items():
        if mode.mode is not None:
            found += _numbers_of(mode.mode, name)
    return {place: (part, attribute) for place, part, attribute in found}


def _is_shown(place, part, attribute):
    """Strengths, frictions and drags that act, and the coupling's stiffness."""
    felt = attribute.endswith(("_n", "_ns_per_m", "_coefficient")) and place.partition(".")[0] not in ("coupling", "workspace")
    return place == "coupling.stiffness_n_per_m" or felt and getattr(part, attribute) > 0


def _low_and_high(part, attribute, value):
    """Range of a slider: from 0, or the least valid value, to three times the value."""
    high = 3.0 * abs(value) or 1.0
    try:
        setattr(part, attribute, 0.0)
        low = 0.0
    except ValueError:
        low = 0.1 * value
    finally:
        setattr(part, attribute, value)
    return min(low, value), max(high, value)


def sliders(live: Any, *places: str) -> Any:
    try:
        import ipywidgets
    except ImportError:
        raise ImportError("sliders need ipywidgets; install python3-ipywidgets") from None
    numbers = _all_numbers(live.scene)
    for place in places:
        if place not in numbers:
            import difflib

            near = difflib.get_close_matches(place, numbers, 1)
            raise KeyError(f"the scene has no number {place!r}; " + (f"did you mean {near[0]!r}?" if near else
                                                                    "there are: " + ", ".join(numbers)))
    shown = places or [place for place, (part, attribute) in numbers.items() if _is_shown(place, part, attribute)]
    says = ipywidgets.Label(value="")
    rows = []
    for place in shown:
        part, attribute = numbers[place]
        value = getattr(part, attribute)
        low, high = _low_and_high(part, attribute, value)
        row = ipywidgets.FloatSlider(value=value, min=low, max=high, step=(high - low) / 200, description=place, continuous_update=True,
                                     layout=ipywidgets.Layout(width="38em"), style={"description_width": "22em"}, readout_format=".3g")
        row.observe(lambda change, place=place: _change(live, place, change["new"], says), names="value")
        rows.append(row)
    return ipywidgets.VBox([*rows, says])


def _change(live, place, value, says):
    """Changes a number of the live scene; what is wrong with it stands below the sliders."""
    scene = live.scene
    part, attribute = _all_numbers(scene)[place]
    try:
        setattr(part, attribute, value)
        live.scene = scene
        says.value = ""
    except (ValueError, KeyError, RuntimeError) as error:
        says.value = str(error)
