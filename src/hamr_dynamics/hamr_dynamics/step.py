"""One 50 us step of one robot, as five pure functions (stages) over any scalar type.

The scheme is the linearly implicit midpoint rule: forces and inertia at the pose half a step ahead, spring and damper
matrices on the left-hand side, so it is second order for smooth motion and stable for stiff contact. Velocity products use
the midpoint velocity predicted with the last acceleration. Unknowns are velocity increments; a leg's two are eliminated
first, which leaves six equations for the base:

    reach_legs -> solve base -> ground (clamp contact forces) -> solve base again -> finish_legs

The first solve has contact linearised on the left-hand side, the second the clamped forces on the right: what moves the
robot never pulls on the ground and never leaves the friction cone.
"""

from __future__ import annotations

from dataclasses import dataclass

from . import scalar, vec
from .contact import Contact, approach, clamp
from .leg import Leg, inertia

ROW6 = tuple((i, j) for i in range(6) for j in range(i + 1))  # lower triangle of a symmetric 6 x 6


@dataclass(frozen=True, slots=True)
class LegState:
    """Hip angles (2,) rad, rates (2,) rad/ms, last accelerations (2,) rad/ms^2."""

    q: tuple
    v: tuple
    a: tuple


def ahead(state: LegState, h) -> tuple[tuple, tuple]:
    """Angles half a step ahead and predicted midpoint rates."""
    q = tuple(x + (0.5 * h) * y for x, y in zip(state.q, state.v, strict=True))
    return q, tuple(y + (0.5 * h) * z for y, z in zip(state.v, state.a, strict=True))


def inverse2(m):
    """Inverse of a symmetric 2 x 2 (11, 12, 22)."""
    scale = 1.0 / (m[0] * m[2] - m[1] * m[1])
    return m[2] * scale, -m[1] * scale, m[0] * scale


def times2(m, x):
    """Symmetric 2 x 2 times (2,)."""
    return m[0] * x[0] + m[1] * x[1], m[1] * x[0] + m[2] * x[1]


def implicit(mass, leg: Leg, h):
    """Left-hand side of the midpoint rule: M + h/2 D + h^2/4 K."""
    matrices = zip(mass, leg.armature, leg.damping, leg.stiffness, strict=True)
    return tuple(m + r + (0.5 * h) * d + (0.25 * h * h) * k for m, r, d, k in matrices)


def finish(state: LegState, increment, h) -> LegState:
    """State after the step."""
    v = tuple(x + y for x, y in zip(state.v, increment, strict=True))
    q = tuple(x + (0.5 * h) * (y + z) for x, y, z in zip(state.q, state.v, v, strict=True))
    return LegState(q, v, tuple(y * (1.0 / h) for y in increment))


def step_suspended(leg_function, state: LegState, drive, parameters, gravity, h) -> tuple[LegState, Leg]:
    """One step of one leg on a fixed, level chassis."""
    q, v_mid = ahead(state, h)
    leg = leg_function(q, state.v, drive, parameters)
    terms = inertia(leg.bodies, v_mid, (0.0, 0.0, 0.0), (0.0, 0.0, gravity))
    push = tuple(h * (f - b) for f, b in zip(leg.force, terms.leg_bias, strict=True))
    return finish(state, times2(inverse2(implicit(terms.leg, leg, h)), push), h), leg


@dataclass(frozen=True, slots=True)
class Reach:
    """A leg eliminated from the equations of motion, with contact on the left (`soft`) and without (`free`).

    Attributes:
        soft_matrix, free_matrix: (21,) contributions to the base's matrix (lower triangle), (angular, linear).
        soft_rhs, free_rhs: (6,) contributions to its right-hand side.
        soft_gain, free_gain: two rows (6,): leg increment = own - gain . base increment.
        soft_own, free_own: (2,).
        solve: (3,) inverse of the free leg matrix.
        jacobian: two columns (3,) of the foot. point: (3,) foot, mm. contact: linearised contact.
        stop: (2,) stops that push.
    """

    soft_matrix: tuple
    soft_rhs: tuple
    soft_gain: tuple
    soft_own: tuple
    free_matrix: tuple
    free_rhs: tuple
    free_gain: tuple
    free_own: tuple
    solve: tuple
    jacobian: tuple
    point: tuple
    contact: Contact
    stop: tuple


def reach_leg(leg_function, state: LegState, drive, parameters, base, ground, h, *, pull=(0.0, 0.0, 0.0)) -> Reach:
    """Eliminates one leg.

    Args:
        base: mapping with omega, omega_mid (3,) rad/ms, velocity (3,) mm/ms, normal (3,) (all in leg-frame axes), height mm, gravity.
        ground: mapping with friction, stiffness, damping, slip_speed.
        pull: (3,) acceleration that gravity along the ground is equivalent to, mm/ms^2.
    """
    q, v_mid = ahead(state, h)
    leg = leg_function(q, state.v, drive, parameters)
    normal = base["normal"]
    terms = inertia(leg.bodies, v_mid, base["omega_mid"], vec.add(vec.scale(normal, base["gravity"]), pull))

    point = tuple(c.value for c in leg.foot)
    jacobian = tuple(tuple(c.d[i] for c in leg.foot) for i in (0, 1))
    velocity = vec.add(vec.add(base["velocity"], vec.cross(base["omega"], point)), tuple(c.rate(state.v) for c in leg.foot))
    touch = approach(
        base["height"] + vec.dot(normal, point), velocity, normal, ground["friction"], h,
        stiffness=ground["stiffness"], damping=ground["damping"], slip_speed=ground["slip_speed"],
    )  # fmt: skip

    free_leg = implicit(terms.leg, leg, h)
    free_rhs_leg = tuple(h * (f - b) for f, b in zip(leg.force, terms.leg_bias, strict=True))
    free_rhs_base = tuple(-h * b for b in terms.base_bias)
    free_base = _rigid_matrix(terms.mass, terms.moment, terms.tensor)
    free = _eliminate(free_leg, terms.coupling, free_base, free_rhs_leg, free_rhs_base)

    # contact: wrench columns of the foot, along the normal and across it
    across, extra = h * touch.slip, h * (touch.grip - touch.slip)
    lever = vec.cross(point, normal) + tuple(normal)
    along = tuple(vec.dot(normal, c) for c in jacobian)
    wrenches = tuple(vec.cross(point, c) + tuple(c) for c in jacobian)
    soft_leg = tuple(
        m + across * vec.dot(jacobian[i], jacobian[j]) + extra * (along[i] * along[j])
        for m, (i, j) in zip(free_leg, ((0, 0), (0, 1), (1, 1)), strict=True)
    )
    soft_coupling = tuple(
        tuple(c + across * w + (extra * along[i]) * n for c, w, n in zip(terms.coupling[i], wrenches[i], lever, strict=True))
        for i in (0, 1)
    )
    point_matrix = _rigid_matrix(1.0, point, vec.point_inertia(1.0, point))
    soft_base = tuple(
        m + across * p + extra * (lever[i] * lever[j]) for m, p, (i, j) in zip(free_base, point_matrix, ROW6, strict=True)
    )
    rise = vec.dot(normal, velocity)
    push = vec.add(vec.scale(velocity, -across), vec.scale(normal, h * touch.push - extra * rise))
    soft_rhs_leg = tuple(f + vec.dot(c, push) for f, c in zip(free_rhs_leg, jacobian, strict=True))
    soft_rhs_base = vec.add(free_rhs_base, vec.cross(point, push) + push)
    soft = _eliminate(soft_leg, soft_coupling, soft_base, soft_rhs_leg, soft_rhs_base)
    return Reach(*soft[:4], *free, jacobian, point, touch, leg.stop)


def _rigid_matrix(mass, moment, tensor):
    """Lower triangle of a rigid body's 6 x 6 mass matrix (angular, linear) about the base origin."""
    x, y, z = moment
    xx, yy, zz, xy, xz, yz = tensor
    # linear rows: force = m a + alpha x moment
    return (xx, xy, yy, xz, yz, zz, 0.0, z, -y, mass, -z, 0.0, x, 0.0, mass, y, -x, 0.0, 0.0, 0.0, mass)


def _eliminate(leg_matrix, coupling, base_matrix, leg_rhs, base_rhs):
    solve = inverse2(leg_matrix)
    gain = tuple(zip(*(times2(solve, (coupling[0][i], coupling[1][i])) for i in range(6)), strict=True))
    own = times2(solve, leg_rhs)
    matrix = tuple(m - (coupling[0][i] * gain[0][j] + coupling[1][i] * gain[1][j]) for m, (i, j) in zip(base_matrix, ROW6, strict=True))
    rhs = tuple(r - (coupling[0][i] * own[0] + coupling[1][i] * own[1]) for i, r in enumerate(base_rhs))
    return matrix, rhs, gain, own, solve


def ground_force(reach: Reach, base_increment, leg_velocity_increment, friction):
    """Force that the ground gives, from the soft solution. N, leg-frame axes."""
    turn, shift = base_increment[:3], base_increment[3:]
    velocity = vec.add(vec.add(reach.contact.velocity, shift), vec.cross(turn, reach.point))
    for column, d in zip(reach.jacobian, leg_velocity_increment, strict=True):
        velocity = vec.add(velocity, vec.scale(column, d))
    return clamp(reach.contact, velocity, friction)


def leg_increment(own, gain, base_increment):
    """Leg velocity increment belonging to a base increment."""
    return tuple(o - sum((g * b for g, b in zip(row, base_increment, strict=True)), 0.0) for o, row in zip(own, gain, strict=True))


def apply_ground(reach: Reach, force, h):
    """What a contact force adds to the free equations: (6,) base right-hand side and (2,) leg increment."""
    kick = vec.scale(force, h)
    pull = tuple(vec.dot(c, kick) for c in reach.jacobian)
    rhs = vec.cross(reach.point, kick) + kick
    rhs = tuple(r - (reach.free_gain[0][i] * pull[0] + reach.free_gain[1][i] * pull[1]) for i, r in enumerate(rhs))
    return rhs, times2(reach.solve, pull)


def solve6(matrix, rhs):
    """Solves a symmetric positive definite 6 x 6 system by LDL^T; matrix as lower triangle (ROW6)."""
    a = {ij: m for ij, m in zip(ROW6, matrix, strict=True)}
    factor, inverse = {}, []
    for j in range(6):
        pivot = a[j, j]
        for k in range(j):
            pivot = pivot - factor[j, k] * a[j, k]
        inverse.append(1.0 / pivot)
        for i in range(j + 1, 6):
            for k in range(j):
                a[i, j] = a[i, j] - factor[j, k] * a[i, k]
            factor[i, j] = a[i, j] * inverse[j]
    y = []
    for i in range(6):
        y.append(rhs[i] - sum((factor[i, k] * y[k] for k in range(i)), 0.0))
    x = [value * d for value, d in zip(y, inverse, strict=True)]
    for i in reversed(range(6)):
        for k in range(i + 1, 6):
            x[i] = x[i] - factor[k, i] * x[k]
    return tuple(x)


@dataclass(frozen=True, slots=True)
class BaseState:
    """Chassis: position mm (world), quaternion wxyz, velocity of the frame origin mm/ms (world), angular velocity rad/ms and last
    angular acceleration rad/ms^2 (chassis axes)."""

    position: tuple
    quaternion: tuple
    velocity: tuple
    omega: tuple
    alpha: tuple


def rotation_matrix(quaternion):
    """Rows of the rotation chassis -> world."""
    w, x, y, z = quaternion
    return (
        (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)),
        (2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)),
        (2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)),
    )


def turn(quaternion, omega, time):
    """Quaternion after turning at omega for `time`, second order, normalised."""
    w, x, y, z = quaternion
    a, b, c = (o * (0.5 * time) for o in omega)
    new = (w - (x * a + y * b + z * c), x + (w * a + y * c - z * b), y + (w * b + z * a - x * c), z + (w * c + x * b - y * a))
    size = 1.0 / scalar.sqrt(new[0] * new[0] + new[1] * new[1] + new[2] * new[2] + new[3] * new[3])
    return tuple(n * size for n in new)


def base_ahead(state: BaseState, h):
    """Pose half a step ahead: quaternion, rows of its rotation, height of the origin, velocity in its axes, predicted midpoint omega."""
    quaternion = turn(state.quaternion, state.omega, 0.5 * h)
    rows = rotation_matrix(quaternion)
    velocity = tuple(sum((rows[i][k] * state.velocity[i] for i in range(3)), 0.0) for k in range(3))
    omega_mid = tuple(w + (0.5 * h) * a for w, a in zip(state.omega, state.alpha, strict=True))
    return quaternion, rows, state.position[2] + (0.5 * h) * state.velocity[2], velocity, omega_mid


def chassis_terms(mass, com, tensor, omega, lift, h):
    """The chassis itself: (21,) matrix and (6,) right-hand side."""
    moment = vec.scale(com, mass)
    about_origin = vec.add(tensor, vec.point_inertia(mass, com))
    force = vec.add(vec.cross(omega, vec.cross(omega, moment)), vec.scale(lift, mass))
    torque = vec.add(vec.cross(omega, vec.apply(about_origin, omega)), vec.cross(moment, lift))
    return _rigid_matrix(mass, moment, about_origin), tuple(-h * x for x in torque + force)


def finish_base(state: BaseState, quaternion, rows, increment, h) -> BaseState:
    """Chassis state after the step, from the pose half a step ahead."""
    shift = increment[3:]
    velocity = tuple(v + vec.dot(row, shift) for v, row in zip(state.velocity, rows, strict=True))
    omega = vec.add(state.omega, increment[:3])
    position = tuple(p + (0.5 * h) * (a + b) for p, a, b in zip(state.position, state.velocity, velocity, strict=True))
    return BaseState(position, turn(quaternion, omega, 0.5 * h), velocity, omega, tuple(d * (1.0 / h) for d in increment[:3]))
