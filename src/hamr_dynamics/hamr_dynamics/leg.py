"""What a plant says about one leg, and what the rest of the dynamics makes of it.

A plant is a pure function `(q, v, drive, parameters) -> Leg` over any scalar type, in the front-left leg frame
(docs/architecture.md). `inertia` turns its bodies into mass matrix, base coupling and bias forces.
"""

from __future__ import annotations

from dataclasses import dataclass

from . import vec
from .jet import Jet


@dataclass(frozen=True, slots=True)
class Body:
    """A rigid body carried by the leg, in the chassis frame.

    Attributes:
        mass: g.
        inertia: (6,) tensor about the centre of mass in chassis axes, g mm^2.
        com: three jets, mm.
        turns: rotations that carry it, outermost first: (unit axis in the chassis frame, angle as a jet), at most two.
    """

    mass: object
    inertia: tuple
    com: tuple[Jet, Jet, Jet]
    turns: tuple[tuple[tuple, Jet], ...] = ()

    def spin(self, i: int) -> tuple:
        """Angular velocity per unit rate of hip angle i."""
        return _sum(vec.scale(axis, angle.d[i]) for axis, angle in self.turns)

    def spin_bias(self, v) -> tuple:
        """Angular acceleration at hip rates v and zero hip acceleration, rad/ms^2; the outer turn carries the inner axis."""
        bias = _sum(vec.scale(axis, angle.bias(v)) for axis, angle in self.turns)
        if len(self.turns) == 2:
            (outer, first), (inner, second) = self.turns
            bias = vec.add(bias, vec.scale(vec.cross(outer, inner), first.rate(v) * second.rate(v)))
        return bias


def _sum(vectors) -> tuple:
    total = (0.0, 0.0, 0.0)
    for v in vectors:
        total = vec.add(total, v)
    return total


@dataclass(frozen=True, slots=True)
class Leg:
    """Everything a plant states about one leg at hip angles q and rates v.

    Attributes:
        bodies: the moving bodies.
        foot: contact point in the chassis frame, three jets, mm.
        force: (2,) generalised hip force of drive, springs, dampers and stops, N mm.
        stiffness: (3,) -d force/dq as (11, 12, 22): only stabilises the implicit step, need not be exact. N mm/rad.
        damping: (3,) -d force/dv as (11, 12, 22): exact, it makes the step second order. N mm ms/rad.
        tips: actuator tip deflections (swing, lift), two jets, mm.
        tip_force: (2,) actuator forces, N.
        torque: (2,) generalised hip force of the drive alone, N mm.
        stop: (2,) 1 where an end stop pushes.
        armature: inertia of the hips that no body carries, as (11, 12, 22), g mm^2.
    """

    bodies: list[Body]
    foot: tuple[Jet, Jet, Jet]
    force: tuple
    stiffness: tuple
    damping: tuple
    tips: tuple[Jet, Jet]
    tip_force: tuple
    torque: tuple
    stop: tuple
    armature: tuple = (0.0, 0.0, 0.0)


PAIRS = ((0, 0), (0, 1), (1, 1))


def project(columns, weights):
    """sum_k w_k c_k c_k^T as (11, 12, 22), for gradients c_k (2,) and scalars w_k."""
    return tuple(sum((w * (c[i] * c[j]) for c, w in zip(columns, weights, strict=True)), 0.0) for i, j in PAIRS)


@dataclass(frozen=True, slots=True)
class Inertia:
    """Inertial terms of a leg on a moving base; rows (angular, linear) of the base acceleration about its origin.

    Attributes:
        mass: g. moment: first mass moment (3,), g mm. tensor: (6,) about the base origin, g mm^2.
        leg: hip mass matrix (11, 12, 22), g mm^2. coupling: two columns (6,), momentum per unit hip rate.
        base_bias: (6,) torque and force needed at zero accelerations. leg_bias: (2,) likewise at the hips.
    """

    mass: object
    moment: tuple
    tensor: tuple
    leg: tuple
    coupling: tuple
    base_bias: tuple
    leg_bias: tuple


def inertia(bodies: list[Body], v, omega, lift) -> Inertia:
    """Newton-Euler over the leg's bodies.

    Args:
        bodies: of a `Leg`.
        v: (2,) hip rates, rad/ms.
        omega: (3,) angular velocity of the base in its own axes, rad/ms.
        lift: (3,) acceleration that gravity is equivalent to (minus gravity), mm/ms^2.
    """
    zero3 = (0.0, 0.0, 0.0)
    mass, moment, tensor = 0.0, zero3, (0.0,) * 6
    leg, coupling = (0.0,) * 3, [zero3 + zero3, zero3 + zero3]
    torque, force, leg_bias = zero3, zero3, [0.0, 0.0]
    for body in bodies:
        m = body.mass
        p = tuple(c.value for c in body.com)
        columns = [tuple(c.d[i] for c in body.com) for i in (0, 1)]
        velocity = tuple(c.rate(v) for c in body.com)
        swirl = vec.cross(omega, vec.add(vec.cross(omega, p), vec.scale(velocity, 2.0)))
        acceleration = vec.add(vec.add(swirl, tuple(c.bias(v) for c in body.com)), lift)
        push = vec.scale(acceleration, m)
        momenta = [vec.scale(c, m) for c in columns]

        mass = mass + m
        moment = vec.add(moment, vec.scale(p, m))
        tensor = vec.add(tensor, vec.add(vec.point_inertia(m, p), body.inertia))
        leg = vec.add(leg, tuple(vec.dot(momenta[i], columns[j]) for i, j in PAIRS))
        force = vec.add(force, push)
        torque = vec.add(torque, vec.cross(p, push))
        angular = [vec.cross(p, k) for k in momenta]
        for i in (0, 1):
            leg_bias[i] = leg_bias[i] + vec.dot(columns[i], push)

        spins = [body.spin(i) for i in (0, 1)]
        spin = vec.add(vec.scale(spins[0], v[0]), vec.scale(spins[1], v[1]))
        total = vec.add(omega, spin)
        turn = vec.add(body.spin_bias(v), vec.cross(omega, spin))
        moment_rate = vec.add(vec.apply(body.inertia, turn), vec.cross(total, vec.apply(body.inertia, total)))
        torque = vec.add(torque, moment_rate)
        if body.turns:
            spun = [vec.apply(body.inertia, s) for s in spins]
            leg = vec.add(leg, tuple(vec.dot(spun[i], spins[j]) for i, j in PAIRS))
            angular = [vec.add(a, s) for a, s in zip(angular, spun, strict=True)]
            for i in (0, 1):
                leg_bias[i] = leg_bias[i] + vec.dot(spins[i], moment_rate)
        coupling = [vec.add(c, a + k) for c, a, k in zip(coupling, angular, momenta, strict=True)]
    return Inertia(mass, moment, tensor, leg, tuple(coupling), torque + force, tuple(leg_bias))
