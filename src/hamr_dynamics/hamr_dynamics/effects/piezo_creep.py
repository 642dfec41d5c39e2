"""The piezo goes on moving after its voltage stopped."""

from __future__ import annotations

from .law import Effect, Form, Input, Parameter

DECADES = (1.0, 10.0, 100.0, 1000.0)


def kelvin_voigt(x: Input, p, z):
    """u + size z, time dz/dt = u - z."""
    moved = (z[0] * p["time"] + x.u * x.step) / (p["time"] + x.step)
    return x.u + p["size"] * moved, (moved,)


def logarithmic(x: Input, p, z):
    """u + size * (four such elements, a decade apart): log-time creep over four decades."""
    return _laddered(x, [p["size"]] * len(DECADES), p["time"], z)


def decades(x: Input, p, z):
    """The same with a size for each decade: creep by any power of time."""
    return _laddered(x, [p[f"size{k + 1}"] for k in range(len(DECADES))], p["time"], z)


def _laddered(x: Input, sizes, shortest, z):
    y, new = x.u, []
    for decade, size, slow in zip(DECADES, sizes, z, strict=True):
        time = decade * shortest
        moved = (slow * time + x.u * x.step) / (time + x.step)
        new.append(moved)
        y = y + size * moved
    return y, tuple(new)


EFFECT = Effect(
    name="piezo_creep",
    part="actuator",
    summary="A slow addition to the drive that follows the voltage over many times the mechanical period.",
    forms=(
        Form("kelvin_voigt", "drive", kelvin_voigt, (
            Parameter("size", "1", 0.05, -0.5, 2.0, "share of the voltage that creeps"),
            Parameter("time", "T", 100.0, 10.0, 1e5, "creep time", shape=True, screen=(15.0, 60.0, 300.0, 3000.0)),
        ), states=1, order=7),
        Form("logarithmic", "drive", logarithmic, (
            Parameter("size", "1", 0.02, -0.5, 1.0, "share of the voltage per decade"),
            Parameter("time", "T", 10.0, 1.0, 100.0, "shortest creep time", shape=True, screen=(2.0, 10.0)),
        ), states=4, order=7),
        Form("decades", "drive", decades, (
            *(Parameter(f"size{k + 1}", "1", 0.02, -0.5, 1.0, f"share of the voltage in decade {k + 1}") for k in range(len(DECADES))),
            Parameter("time", "T", 10.0, 1.0, 100.0, "shortest creep time", shape=True, screen=(5.0,)),
        ), states=4, order=7),
    ),
    experiment="steps held for 1 to 10 s",
    source="hamr_facts 7, effect 12; Jung and Gweon 2000",
    mimics=("viscoelasticity",),  # below resonance the drive is the spring's force
)  # fmt: skip
