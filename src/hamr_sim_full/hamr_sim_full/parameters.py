"""HAMR-full's parameters of one leg, from numbers.yaml, in the mirrored front-left frame."""

from __future__ import annotations

from hamr_description.numbers import leg_value, value

from . import actuator

LINKS = ("S1", "S2", "S3", "S4", "L1", "L2", "L3", "L4")
FLEXURES = ("s1", "s2", "fb1", "l1", "l2", "fb3")


def leg_parameters(leg: str, *, rail: bool = True) -> dict:
    """Flat mapping name -> number or tuple of numbers (g, mm, ms, N, V).

    Args:
        leg: fl, rl, fr or rr.
        rail: with the bias rail on (225 V); without it the force loses its deflection term (the "rail off" figures).
    """

    def get(path: str):
        number = leg_value(leg, path)
        return number if isinstance(number, float) else tuple(float(x) for x in number)

    origin = {name: get(f"origins.{name}") for name in ("swing_slider", "s1", "s2", "fb1", "lift_slider", "l1", "l2", "fb3")}
    swing, lift, s1, s2, l1, l2 = (origin[n] for n in ("swing_slider", "lift_slider", "s1", "s2", "l1", "l2"))
    law = actuator.bender()
    parameters = {
        "hip": get("hip"),
        "foot_in_L4": get("foot_in_L4"),
        "swing_slider": swing, "lift_slider": lift, "s1": s1, "l1": l1, "fb1": origin["fb1"], "fb3": origin["fb3"],
        "s1_x": swing[0] + s1[0], "s1_y": swing[1] + s1[1], "s1_z": swing[2] + s1[2], "swing_coupler": s2[1],
        "s2_height": swing[2] + s1[2] + s2[2],
        "l1_y": lift[1] + l1[1], "l1_z": lift[2] + l1[2], "l2_x": lift[0] + l1[0] + l2[0], "lift_coupler": l2[1],
        "drive_force": 2.0 * law.c0,
        "drive_spring": law.rail_stiffness if rail else 0.0,
        "tip_stiffness": value("actuator.stiffness"),
        "tip_damping": value("actuator.damping"),
        "stop": value("actuator.stop"),
        "stop_stiffness": value("actuator.stop_stiffness"),
        "stop_damping": value("actuator.stop_damping"),
    }  # fmt: skip
    for loop, links in {"s3": ("chassis", "S3"), "l3": ("chassis", "L3"), "fb2": ("S4", "L4")}.items():
        points = leg_value(leg, f"closures.{loop}")
        parameters |= {f"{loop}_in_{link}": tuple(float(x) for x in point) for link, point in zip(links, points, strict=True)}
    for flexure in FLEXURES:
        parameters[f"k_{flexure}"] = get(f"flexures.{flexure}.stiffness")
        parameters[f"b_{flexure}"] = get(f"flexures.{flexure}.damping")
    for link in LINKS:
        parameters |= {f"{kind}_{link}": get(f"links.{link}.{kind}") for kind in ("mass", "com", "inertia")}
    return parameters
