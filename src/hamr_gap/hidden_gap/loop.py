"""One compiled loop for every case: voltages in, laws in their order, end stops, mj_step, angles and tips out."""

from __future__ import annotations

import ctypes
from functools import cache
from pathlib import Path

import mujoco
import numpy as np
from llvmlite import ir
from numba import njit, types
from numba.extending import intrinsic

from .laws.law import ARMATURE, COMMAND, GAIN, RQ, RTAU, RV, TAU, TIP, Q, U, V

FAR = 3.0  # rad; beyond, a run counts as diverged


@cache
def step_address() -> int:
    """Address of mj_step in the installed library, whose clock is stopped.

    MuJoCo's Python module has every part of a step timed for a profiler that nobody reads here: half of what a leg's step takes.
    """
    version = mujoco.mj_versionString()
    names = (f"libmujoco.so.{version}", f"libmujoco.{version}.dylib", "mujoco.dll")
    folder = Path(mujoco.__file__).parent
    library = ctypes.CDLL(str(next(path for path in map(folder.joinpath, names) if path.exists())))
    ctypes.c_void_p.in_dll(library, "mjcb_time").value = None
    return ctypes.cast(library.mj_step, ctypes.c_void_p).value


@intrinsic
def _call_step(context, address, model, data):
    """void mj_step(model, data), by addresses."""
    word = ir.IntType(64)

    def generate(context, builder, signature, args):
        builder.call(builder.inttoptr(args[0], ir.FunctionType(ir.VoidType(), [word, word]).as_pointer()), args[1:])
        return context.get_dummy_value()

    return types.void(types.intp, types.intp, types.intp), generate


@intrinsic
def _call_law(context, address, i, t, dt, w, p, s):
    """A compiled law, by its address; w, p and s are addresses too."""
    word, real = ir.IntType(64), ir.DoubleType()

    def generate(context, builder, signature, args):
        kind = ir.FunctionType(ir.VoidType(), [word, real, real, word, word, word])
        builder.call(builder.inttoptr(args[0], kind.as_pointer()), args[1:])
        return context.get_dummy_value()

    return types.void(types.intp, types.intp, types.float64, types.float64, types.intp, types.intp, types.intp), generate


@njit(cache=True, nogil=True)
def run(step, model, data, qpos, qvel, ctrl, applied, bias, armature, dofs, rotors, stops, mass, ratio, gain, preload, neutral, commands,
        parts, dt, addresses, joints, first_p, first_s, p, s, w, angles, tips):  # fmt: skip
    """Fill angles (n, 2) rad and tips (n, 2) mm at the start of each of n commands (n, 2) V, each held for `parts` steps of dt.

    MuJoCo's Euler step moves positions with the new rate, so that they stand half a step ahead of it: forces get the rate that
    belongs to the position, half a step on, and the mean of two neighbouring positions is on time. Both to second order.
    """
    now, before = w[Q : Q + 2].copy(), w[Q : Q + 2].copy()
    tip, tip_before = w[TIP : TIP + 2].copy(), w[TIP : TIP + 2].copy()
    base, old, old_rotor, hit = armature[dofs].copy(), qvel[dofs].copy(), qvel[rotors].copy(), np.zeros(2)
    last, change = np.zeros(bias.size), np.zeros(bias.size)
    for k in range(commands.shape[0]):
        for part in range(parts):
            before[:] = now
            tip_before[:] = tip
            for i in range(2):
                now[i] = w[Q + i] = qpos[dofs[i]]
                v, rotor = qvel[dofs[i]], qvel[rotors[i]]
                w[V + i], w[RQ + i], w[RV + i] = 1.5 * v - 0.5 * old[i], qpos[rotors[i]], 1.5 * rotor - 0.5 * old_rotor[i]
                old[i], old_rotor[i] = v, rotor
                w[COMMAND + i] = w[U + i] = commands[k, i] - neutral
                w[GAIN + i], w[TAU + i], w[RTAU + i], w[ARMATURE + i] = gain[i], preload[i], 0.0, 0.0
                w[TIP + i] = ratio[i] * w[RQ + i]
            if not (abs(w[Q]) < FAR and abs(w[Q + 1]) < FAR and abs(w[RQ]) < FAR and abs(w[RQ + 1]) < FAR):
                angles[k:] = np.nan
                armature[dofs] = base
                return
            t = (k * parts + part) * dt
            for n in range(addresses.shape[0]):
                place = w.ctypes.data
                _call_law(addresses[n], joints[n], t, dt, place, p.ctypes.data + 8 * first_p[n], s.ctypes.data + 8 * first_s[n])
            tip[:] = w[TIP : TIP + 2]
            if k == 0 and part == 0:
                before[:] = now
                tip_before[:] = tip
            if part == 0:
                for i in range(2):
                    angles[k, i] = 0.5 * (before[i] + now[i])
                    tips[k, i] = 0.5 * (tip_before[i] + tip[i])
            for i in range(2):
                d = dofs[i]
                hit[i] = _stop(w[Q + i], w[V + i] - 0.5 * dt * hit[i] / mass[i], stops[i], mass[i], dt)
                applied[d] = w[TAU + i] + hit[i] - 0.5 * change[d]
                if rotors[i] != d:
                    applied[rotors[i]] = w[RTAU + i]
                armature[d] = base[i] + w[ARMATURE + i]
                ctrl[i] = w[U + i] + neutral
            _call_step(step, model, data)
            change[:] = bias - last
            last[:] = bias
            if k == 0 and part == 0:
                change[:] = 0.0
    armature[dofs] = base


@njit
def _stop(q, v, stop, mass, dt):
    """A spring and damper beyond the end of travel that never pulls; mean over the part of the step spent there.

    v is the rate without the stop's force, which is solved for.
    """
    low, high, stiffness, damping = stop
    over, way = max(q - high, low - q), abs(v) * dt
    if over <= -0.5 * way or (over <= 0.0 and way == 0.0):
        return 0.0
    side = 1.0 if q - high > low - q else -1.0
    share, depth = 1.0, over
    if over < 0.5 * way:
        share = over / way + 0.5
        depth = 0.5 * (over + 0.5 * way)
    return -side * share * max(0.0, stiffness * depth + damping * side * v) / (1.0 + 0.5 * share * damping * dt / mass)
