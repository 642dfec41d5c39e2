"""What /run_info says of a run: one JSON object, written by the simulator, read strictly."""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict, dataclass, field, fields
from functools import cache
from importlib.metadata import PackageNotFoundError, version

from hamr_description.errors import BagError
from hamr_description.numbers import all_numbers
from hamr_description.rates import SERVO_HZ, TARGET_HZ

SCHEMA = 1
ENVIRONMENTS = ("ground", "suspended")
UNITS = {
    "time": "s", "length": "m", "angle": "rad", "force": "N", "torque": "N m", "voltage": "V", "quaternion": "xyzw",
}  # fmt: skip
#: The fields that measured data may rest on.
CONDITIONS = ("environment", "samples_per_frame", "servo_hz", "target_hz", "units")
_PACKAGES = ("hamr", "numpy", "numba", "mujoco", "rosbags", "mcap")


@cache
def parameters_hash() -> str:
    """Hash over every number of the description (path, value, unit), 16 hex digits."""
    digest = hashlib.sha256()
    for number in all_numbers():
        values = number.value.tolist() if hasattr(number.value, "tolist") else number.value
        digest.update(json.dumps([number.path, values, number.unit]).encode())
    return digest.hexdigest()[:16]


@cache
def _versions() -> dict[str, str]:
    found = {}
    for package in _PACKAGES:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            continue
    return found


@dataclass(frozen=True, slots=True, kw_only=True)
class RunInfo:
    """Content of /run_info. What stands first is all that a bag from a real robot needs; the rest describes a simulation.

    Training and the gap workflow read the CONDITIONS only.

    Attributes:
        environment: "ground" or "suspended".
        samples_per_frame: servo samples kept of each period; the sample rate is this times target_hz.
        as_measured: empty, or how a simulated bag was made to look measured ({"noise": ..., "seed": ...}).
        excitation: parameters of the excitation (`excitation(**parameters)`), empty in closed loop.
        effects: effects and changes that were added to the model, as in an effects file; effects_hash: of all of them.
        parameters_hash: of the description's numbers.
    """

    environment: str
    samples_per_frame: int
    servo_hz: int = SERVO_HZ
    target_hz: int = TARGET_HZ
    units: dict[str, str] = field(default_factory=UNITS.copy)
    as_measured: dict[str, float] = field(default_factory=dict)
    backend: str = ""
    engine: str = ""
    seed: int = 0
    excitation: dict[str, object] = field(default_factory=dict)
    effects: list[dict] = field(default_factory=list)
    effects_hash: str = ""
    parameters_hash: str = ""
    versions: dict[str, str] = field(default_factory=dict)
    schema: int = SCHEMA

    @classmethod
    def of_simulation(cls, **values: object) -> RunInfo:
        """Run information of a simulation: hash and versions are filled in."""
        return cls(parameters_hash=parameters_hash(), versions=dict(_versions()), **values)

    @property
    def sample_hz(self) -> int:
        """Samples per second in the servo topics."""
        return self.samples_per_frame * self.target_hz

    def as_dict(self) -> dict:
        """JSON-able."""
        return asdict(self)

    def to_json(self) -> str:
        """The text of /run_info."""
        return json.dumps(asdict(self), allow_nan=False)

    @classmethod
    def conditions(cls, text: str) -> RunInfo:
        """Rates, units and environment alone; whatever else /run_info says is not looked at."""
        return cls._checked({key: value for key, value in _object(text).items() if key in CONDITIONS})

    @classmethod
    def from_json(cls, text: str) -> RunInfo:
        """Parse the whole; BagError names the key that is missing, unknown or of the wrong type."""
        return cls._checked(_object(text))

    @classmethod
    def _checked(cls, found: dict) -> RunInfo:
        if found.get("schema", SCHEMA) != SCHEMA:
            raise BagError(f"/run_info has schema {found['schema']}, this program reads schema {SCHEMA}; use the version that recorded it.")
        kinds = {f.name: _KINDS[f.type.split("[")[0]] for f in fields(cls)}  # annotations are text here
        for key in ("environment", "samples_per_frame"):
            if key not in found:
                raise BagError(f"/run_info lacks '{key}'; correct what publishes it.")
        for key, given in found.items():
            if key not in kinds:
                raise BagError(f"/run_info has the unknown key '{key}'; it takes {', '.join(kinds)}.")
            if not isinstance(given, kinds[key]) or isinstance(given, bool):
                raise BagError(f"/run_info: '{key}' must be a {kinds[key].__name__}, but is {given!r}; correct what publishes it.")
        info = cls(**found)
        if info.environment not in ENVIRONMENTS:
            raise BagError(f"/run_info: environment is '{info.environment}'; it must be one of {', '.join(ENVIRONMENTS)}.")
        if info.units != UNITS:
            wrong = next(key for key in {**UNITS, **info.units} if info.units.get(key) != UNITS.get(key))
            raise BagError(f"/run_info: unit of {wrong} is {info.units.get(wrong)!r}; bags hold SI units ({UNITS.get(wrong)!r}).")
        if min(info.samples_per_frame, info.servo_hz, info.target_hz) < 1:
            raise BagError("/run_info: rates and samples_per_frame must be positive; correct what publishes it.")
        return info


def _object(text: str) -> dict:
    try:
        found = json.loads(text)
    except (json.JSONDecodeError, RecursionError) as error:
        raise BagError(f"/run_info is not JSON ({error}); correct what publishes it and record again.") from None
    if not isinstance(found, dict):
        raise BagError("/run_info is not a JSON object; correct what publishes it and record again.")
    return found


_KINDS = {"str": str, "int": int, "dict": dict, "list": list}
