"""The compiled loop of the whole robot: voltages in, laws of every leg, end stops, surface and tether, mj_step, coordinates out."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from ..laws.law import ARMATURE, COMMAND, GAIN, RQ, RTAU, RV, TAU, TIP, Q, U, V
from ..loop import _call_law, _call_step, _stop

FAR = 3.0  # rad; beyond, a run counts as diverged


@njit(cache=True, nogil=True)
def walk(step, model, data, qpos, qvel, ctrl, applied, dofs, stops, mass, gain, preload, neutral, commands, every, parts, dt,
         addresses, legs, joints, first_p, first_s, p, s, w,
         pair_friction, places, feet, friction, fall, slip, force, position, rotation, centre, pull, coil, reach, hook, home,
         marks, out, mark_qpos, mark_qvel):  # fmt: skip
    """Run commands (n, 8) V, each held for `parts` steps of dt; False if it diverges.

    Every `every`-th sample's coordinates go to out (rows, nq), as means of two neighbouring steps, which are on time (see loop.run);
    the state itself at samples `marks` to mark_qpos and mark_qvel.
    """
    before, old, foot = qpos.copy(), qvel.copy(), places[feet]
    row, mark = 0, 0
    offset, arm, total = np.zeros(3), np.zeros(3), np.zeros(3)
    for k in range(commands.shape[0]):
        for part in range(parts):
            if part == 0 and mark < marks.size and marks[mark] == k:
                mark_qpos[mark], mark_qvel[mark] = qpos, qvel
                mark += 1
            if part == 0 and k % every == 0:
                out[row] = 0.5 * (before + qpos)
                row += 1
            before[:] = qpos
            for j in range(dofs.size):
                leg, i, d = j // 2, j % 2, dofs[j]
                q, v = qpos[d + 1], 1.5 * qvel[d] - 0.5 * old[d]
                if not abs(q) < FAR:
                    return False
                w[leg, Q + i] = w[leg, RQ + i] = q
                w[leg, V + i] = w[leg, RV + i] = v
                w[leg, COMMAND + i] = w[leg, U + i] = commands[k, j] - neutral
                w[leg, GAIN + i], w[leg, TAU + i] = gain[j], preload[j]
                w[leg, RTAU + i] = w[leg, ARMATURE + i] = w[leg, TIP + i] = 0.0
            old[:] = qvel
            t = (k * parts + part) * dt
            for n in range(addresses.size):
                place = w.ctypes.data + 8 * w.shape[1] * legs[n]
                _call_law(addresses[n], joints[n], t, dt, place, p.ctypes.data + 8 * first_p[n], s.ctypes.data + 8 * first_s[n])
            for j in range(dofs.size):
                leg, i = j // 2, j % 2
                applied[dofs[j]] = w[leg, TAU + i] + _stop(w[leg, Q + i], w[leg, V + i], stops[j], mass[j], dt)
                ctrl[j] = w[leg, U + i] + neutral
            if fall > 0.0:
                for f in range(feet.size):
                    here = places[feet[f]]
                    way = math.hypot(here[0] - foot[f, 0], here[1] - foot[f, 1])
                    pair_friction[f, :2] = friction * (1.0 - fall * -math.expm1(-way / dt / slip))
                    foot[f] = here
            if coil > 0.0 or pull[0] != 0.0 or pull[1] != 0.0 or pull[2] != 0.0:
                for a in range(3):
                    offset[a] = rotation[3 * a] * hook[0] + rotation[3 * a + 1] * hook[1] + rotation[3 * a + 2] * hook[2]
                    arm[a] = position[a] + offset[a] - centre[a]
                    total[a] = pull[a]
                away = position + offset - home
                distance = math.sqrt(np.sum(away * away))
                total -= coil * away / (distance + reach)
                force[:3] = total
                force[3:] = np.cross(arm, total)
            _call_step(step, model, data)
    return True
