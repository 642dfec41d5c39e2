"""MuJoCo's own matrices with hard loop closures: the truth that tests hold the kernels against.

MuJoCo's constraints are slightly soft; here its mass matrix, forces and Jacobians enter a dense solve that is exact.
"""

from __future__ import annotations

import mujoco
import numpy as np

RANK_TOLERANCE = 1e-5  # of the largest singular value; redundant closure rows lie far below, independent ones far above


def loop_gap(model: mujoco.MjModel, data: mujoco.MjData) -> np.ndarray:
    """(3 loops,) closure errors in world axes, mm, at the present kinematics."""
    first, second = _sites(model)
    return (data.site_xpos[first] - data.site_xpos[second]).ravel()


def loop_jacobian(model: mujoco.MjModel, data: mujoco.MjData) -> np.ndarray:
    """(3 loops, nv) derivative of `loop_gap`; nine rows per leg, of which six are independent."""
    return _difference(model, data, mujoco.mj_jac)


def loop_bias(model: mujoco.MjModel, data: mujoco.MjData) -> np.ndarray:
    """(3 loops,) second derivative of `loop_gap` at zero acceleration, mm/ms^2."""
    return _difference(model, data, mujoco.mj_jacDot) @ data.qvel


def motion_space(jacobian: np.ndarray) -> np.ndarray:
    """(nv, freedom) orthonormal basis of the velocities that keep the loops closed."""
    if not len(jacobian):
        return np.eye(jacobian.shape[1])
    _, size, rows = np.linalg.svd(jacobian)
    return rows[np.count_nonzero(size > RANK_TOLERANCE * size[0]) :].T


def mass_matrix(model: mujoco.MjModel, data: mujoco.MjData) -> np.ndarray:
    """(nv, nv) of the open chains."""
    full = np.empty((model.nv, model.nv))
    mujoco.mj_fullM(model, data, full)
    return full


def hard_qacc(model: mujoco.MjModel, data: mujoco.MjData, volts: np.ndarray) -> np.ndarray:
    """Acceleration (nv,) at the present qpos, qvel and qfrc_applied under voltages (8,) V, loops exactly closed, no contact.

    qpos and qvel should satisfy the closures (`close_loops`).
    """
    data.ctrl[:] = volts
    mujoco.mj_forward(model, data)
    jacobian = loop_jacobian(model, data)
    free = motion_space(jacobian)
    particular = np.linalg.lstsq(jacobian, -loop_bias(model, data), rcond=RANK_TOLERANCE)[0] if len(jacobian) else np.zeros(model.nv)
    mass = mass_matrix(model, data)
    force = data.qfrc_smooth - mass @ particular
    return particular + free @ np.linalg.solve(free.T @ mass @ free, free.T @ force)


def close_loops(model: mujoco.MjModel, data: mujoco.MjData, held: np.ndarray, values: np.ndarray, rates: np.ndarray) -> None:
    """Set joint coordinates and rates that satisfy the closures, with held @ joint coordinates = values, and likewise the rates.

    Args:
        held: (k, nv) combinations of dofs to prescribe, 0 for the base's; values, rates: (k,).
    The base keeps its state. Newton's method from the present coordinates; ValueError where 1e-12 mm is not reached.
    """
    joints = slice(6 if model.nq > model.nv else 0, None)
    q, v = data.qpos[model.nq - model.nv :][joints], data.qvel[joints]
    for _ in range(50):
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        slope = np.vstack([loop_jacobian(model, data), held])[:, joints]
        error = np.concatenate([loop_gap(model, data), held[:, joints] @ q - values])
        if np.abs(error).max() < 1e-12:
            v[:] = np.linalg.lstsq(slope, np.concatenate([np.zeros(len(slope) - len(held)), rates]), rcond=RANK_TOLERANCE)[0]
            return
        q -= np.linalg.lstsq(slope, error, rcond=RANK_TOLERANCE)[0]
    raise ValueError(f"The loops of the MuJoCo model do not close: {np.abs(error).max():.1e} mm is left; ask for smaller angles.")


def _sites(model: mujoco.MjModel) -> tuple[np.ndarray, np.ndarray]:
    return model.eq_obj1id, model.eq_obj2id


def _difference(model: mujoco.MjModel, data: mujoco.MjData, jacobian) -> np.ndarray:
    """Stacked point Jacobians of the first sites minus those of the second."""
    rows = np.zeros((model.neq, 3, model.nv))
    part = np.empty((3, model.nv))
    for sites, sign in zip(_sites(model), (1, -1), strict=True):
        for row, site in zip(rows, sites, strict=True):
            jacobian(model, data, part, None, data.site_xpos[site], model.site_bodyid[site])
            row += sign * part
    return rows.reshape(-1, model.nv)
