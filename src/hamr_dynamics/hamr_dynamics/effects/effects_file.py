"""Effects files: what a YAML file says is to be added to a model, checked before anything is run.

Parameters are in SI and in the frame of each leg, that of the front-left one (docs/architecture.md): positive angles, torques and
voltages about neutral are those of the front-left leg's mirror image, so that equal numbers on all legs are a robot as symmetric as
before. `hamr_gap` writes them the same way. What acts on the chassis is in the axes of base_link or, for forces, of the ground.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import yaml

from hamr_description.errors import ConfigError

from .bank import CHANGES
from .law import Form, Parameter
from .library import find, library
from .places import joints_of, legs_of
from .si import si_unit

#: Kinds of forms that act on the robot as a whole and have no joints.
OF_THE_CHASSIS = ("chassis", "tow")
#: Kinds of forms whose places are legs.
OF_LEGS = ("pair", "foot", "leg")


@dataclass(frozen=True)
class PlacedEffect:
    """An effect at its places.

    Attributes:
        effect, form: names in the library.
        joints: canonical names in canonical order; empty for what acts on the chassis.
        parameters: name -> value in SI (`si.si_unit` of its dimension), every parameter of the form.
    """

    effect: str
    form: str
    joints: tuple[str, ...]
    parameters: Mapping[str, float]

    def __post_init__(self) -> None:
        try:
            form = find(self.effect, self.form)
            object.__setattr__(self, "form", form.name)
            object.__setattr__(self, "joints", _places(form, self.joints))
            object.__setattr__(self, "parameters", _checked(form, self.parameters))
        except ConfigError as error:
            raise ConfigError(f"{self.effect}: {error}" if not str(error).startswith(("There", "Effect")) else str(error)) from None

    @property
    def law(self) -> Form:
        """Its form."""
        return find(self.effect, self.form)

    @property
    def legs(self) -> tuple[str, ...]:
        """The legs of its joints, for forms that act on legs."""
        return legs_of(self.joints)

    def as_dict(self) -> dict:
        """As in the file."""
        units = {p.name: si_unit(p.dimension) for p in self.law.parameters}
        parameters = {name: {"value": x, "unit": units[name]} for name, x in self.parameters.items()}
        joints = {"joints": list(self.joints)} if self.joints else {}
        return {"effect": self.effect, "form": self.form, **joints, "parameters": parameters}


@dataclass(frozen=True)
class Change:
    """A re-tuned parameter: name of `bank.CHANGES`, joints as in `PlacedEffect`, value in SI that is added (gain: relative)."""

    change: str
    joints: tuple[str, ...]
    value: float

    def __post_init__(self) -> None:
        if self.change not in CHANGES:
            raise ConfigError(f"there is no change '{self.change}'; known are {', '.join(CHANGES)}.")
        if not self.joints:
            raise ConfigError(f"{self.change}: it has no joints; name some, or all.")
        object.__setattr__(self, "joints", joints_of(self.joints))
        object.__setattr__(self, "value", _finite(self.change, self.value))
        if self.change == "gain" and self.value <= -1.0:
            raise ConfigError(f"gain: {self.value!r} would turn the drive round; choose more than -1.")

    def as_dict(self) -> dict:
        """As in the file."""
        return {"change": self.change, "joints": list(self.joints), "value": self.value, "unit": si_unit(CHANGES[self.change])}


@dataclass(frozen=True)
class EffectsFile:
    """What is added to a model; empty changes nothing."""

    effects: tuple[PlacedEffect, ...] = ()
    changes: tuple[Change, ...] = field(default=())

    def __post_init__(self) -> None:
        _once((f"{e.effect} ({e.form})", joint) for e in self.effects for joint in e.joints or ("the chassis",))
        _once((c.change, joint) for c in self.changes for joint in c.joints)

    def __bool__(self) -> bool:
        return bool(self.effects or self.changes)

    @property
    def entries(self) -> list[dict]:
        """All effects and changes, each as in the file."""
        return [entry.as_dict() for entry in (*self.effects, *self.changes)]

    def as_dict(self) -> dict:
        """As in the file."""
        parts = {"effects": [e.as_dict() for e in self.effects], "changes": [c.as_dict() for c in self.changes]}
        return {name: entries for name, entries in parts.items() if entries or name == "effects"}

    @property
    def hash(self) -> str:
        """16 hex digits, equal for equal content; empty for nothing."""
        return hashlib.sha256(json.dumps(self.as_dict()).encode()).hexdigest()[:16] if self else ""


def write(effects: EffectsFile, path: str | Path) -> None:
    """Writes a file that `read` takes back to the last bit."""
    Path(path).write_text(yaml.safe_dump(effects.as_dict(), sort_keys=False, default_flow_style=None, width=140))


def read(path: str | Path) -> EffectsFile:
    """Reads a file; ConfigError says in one sentence which file, what is wrong and what to do."""
    try:
        return parse(yaml.load(Path(path).read_text(), _Strict))
    except ConfigError as error:
        raise ConfigError(f"Effects file '{path}': {error}") from None
    except (OSError, UnicodeDecodeError) as error:
        raise ConfigError(f"The effects file '{path}' cannot be read ({error}); give a YAML file.") from None
    except yaml.YAMLError as error:
        problem = " ".join(str(error).split())
        raise ConfigError(f"The effects file '{path}' is no YAML ({problem}); correct it.") from None


def load(effects: str | Path | EffectsFile | None) -> EffectsFile:
    """An effects file, however it is given; empty or None is none."""
    if isinstance(effects, EffectsFile):
        return effects
    return read(effects) if effects else EffectsFile()


def refuse(effects: str | Path | EffectsFile | None, engine: str) -> None:
    """ConfigError if there are effects: only the kernel engine takes them."""
    if load(effects):
        raise ConfigError(f"Engine '{engine}' takes no effects: effects need the kernel engine.")


def parse(content: object) -> EffectsFile:
    """An effects file from plain values, as YAML has them."""
    _keys("the file", content, required=("effects",), optional=("changes",))
    placed = [_number("effect", i, _effect, entry) for i, entry in enumerate(_list("effects", content["effects"]))]
    changes = [_number("change", i, _change, entry) for i, entry in enumerate(_list("changes", content.get("changes", [])))]
    return EffectsFile(tuple(placed), tuple(changes))


class _Strict(yaml.SafeLoader):
    """A safe loader that takes no key twice."""

    def construct_mapping(self, node, deep=False):
        keys = [key.value for key, _ in node.value if isinstance(key, yaml.ScalarNode)]
        if len(keys) != len(set(keys)):
            raise ConfigError(f"key '{next(k for k in keys if keys.count(k) > 1)}' stands twice in one place; leave one of them out.")
        return super().construct_mapping(node, deep)


def _number(kind: str, i: int, build, entry):
    try:
        return build(entry)
    except ConfigError as error:
        raise ConfigError(f"{kind} {i + 1}: {error}") from None


def _effect(entry: object) -> PlacedEffect:
    _keys("it", entry, required=("effect", "parameters"), optional=("form", "joints"))
    name, form = _text("effect", entry["effect"]), _text("form", entry.get("form", ""))
    if form == "" and name in library() and len(library()[name].forms) > 1:
        raise ConfigError(f"{name}: it needs a form ({', '.join(f.name for f in library()[name].forms)}).")
    law = find(name, form)
    given = entry["parameters"]
    if not isinstance(given, Mapping):
        raise ConfigError(f"{name}: parameters must be a mapping; give name: value.")
    dimensions = {p.name: p.dimension for p in law.parameters}
    values = {str(key): _value(f"{name}: {key}", x, si_unit(dimensions.get(key, "1"))) for key, x in given.items()}
    return PlacedEffect(name, law.name, _words(entry.get("joints", [])), values)


def _change(entry: object) -> Change:
    _keys("it", entry, required=("change", "joints", "value"), optional=("unit",))
    name = _text("change", entry["change"])
    unit = si_unit(CHANGES.get(name, "1"))
    if name in CHANGES and entry.get("unit", unit) != unit:
        raise ConfigError(f"{name}: unit is {entry['unit']!r}; give the value in {unit}.")
    return Change(name, _words(entry["joints"]), _finite(name, entry["value"]))


def _value(where: str, given: object, unit: str) -> float:
    """A number, or {value, unit}."""
    if isinstance(given, Mapping):
        _keys(where, given, required=("value", "unit"))
        if given["unit"] != unit:
            raise ConfigError(f"{where} has the unit {given['unit']!r}; give it in {unit}.")
        given = given["value"]
    return _finite(where, given)


def _finite(where: str, given: object) -> float:
    """A number; YAML reads 1e-6 as text, a person does not."""
    try:
        number = math.nan if isinstance(given, bool) else float(given)
    except (TypeError, ValueError, OverflowError):
        number = math.nan
    if not math.isfinite(number):
        raise ConfigError(f"{where} is {given!r}; give a finite number.")
    return number


def _places(form: Form, joints: Iterable[str]) -> tuple[str, ...]:
    found = joints_of(tuple(joints))
    if form.acts in OF_THE_CHASSIS:
        if found:
            raise ConfigError("it acts on the chassis; leave joints out.")
    elif not found:
        raise ConfigError("it has no joints; name some, or all.")
    elif form.acts in OF_LEGS:
        legs_of(found)
    return found


def _checked(form: Form, given: Mapping[str, float]) -> dict[str, float]:
    """All parameters in the form's order, within what is physically possible."""
    known = {p.name: p for p in form.parameters}
    if unknown := [name for name in given if name not in known]:
        raise ConfigError(f"form {form.name} has no parameter '{unknown[0]}'; it takes {', '.join(known)}.")
    if missing := [name for name in known if name not in given]:
        raise ConfigError(f"form {form.name} lacks its parameter '{missing[0]}'; give it in {si_unit(known[missing[0]].dimension)}.")
    values = {name: _finite(name, given[name]) for name in known}
    for name, value in values.items():
        _possible(known[name], value)
    return values


def _possible(parameter: Parameter, value: float) -> None:
    """Bounds of ratios hold as they are; those of the rest are in a machine's scales, where only the sign is hard."""
    if parameter.dimension == "1":
        low, high, said = parameter.low, parameter.high, f"choose {parameter.low:g} to {parameter.high:g}"
    else:
        low, high, said = (0.0 if parameter.low >= 0.0 else -math.inf), math.inf, "it must not be negative"
        if parameter.low > 0.0 and value == 0.0:
            raise ConfigError(f"{parameter.name} is 0; it must be positive.")
    if not low <= value <= high:
        raise ConfigError(f"{parameter.name} is {value!r}; {said}.")


def _once(places: Iterable[tuple[str, str]]) -> None:
    seen = set()
    for what, where in places:
        if (what, where) in seen:
            raise ConfigError(f"{what} stands twice at {where}; leave one of them out.")
        seen.add((what, where))


def _keys(where: str, given: object, *, required: tuple[str, ...], optional: tuple[str, ...] = ()) -> None:
    if not isinstance(given, Mapping):
        raise ConfigError(f"{where} must be a mapping with {', '.join(required)}, but is {given!r:.60}; see docs/effects.md.")
    if unknown := [key for key in given if key not in (*required, *optional)]:
        raise ConfigError(f"{where} has the unknown key '{unknown[0]}'; known are {', '.join((*required, *optional))}.")
    if missing := [key for key in required if key not in given]:
        raise ConfigError(f"{where} lacks '{missing[0]}'; see docs/effects.md.")


def _list(name: str, given: object) -> list:
    if not isinstance(given, list):
        raise ConfigError(f"'{name}' must be a list; see docs/effects.md.")
    return given


def _text(name: str, given: object) -> str:
    if not isinstance(given, str):
        raise ConfigError(f"'{name}' is {given!r}; give a name.")
    return given


def _words(given: object) -> tuple[str, ...]:
    given = [given] if isinstance(given, str) else given
    if not isinstance(given, list) or not all(isinstance(word, str) for word in given):
        raise ConfigError(f"joints is {given!r:.60}; give a list of names.")
    return tuple(given)
