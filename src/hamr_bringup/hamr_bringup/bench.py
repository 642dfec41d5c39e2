"""`hamr bench`: what a step costs, measured side by side in one run, with ratios.

Every contender runs in turn, many rounds; its figure is the processor time of its best round, which other load on the
machine disturbs least, and ratios are of best rounds. All kernels run the leg law and a trot on the ground; MuJoCo runs the
same trot open loop with the same contact law, in a compiled loop around mj_step.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping
from time import perf_counter, thread_time

import mujoco
import numpy as np
from tqdm import tqdm

from hamr_description import mjcf
from hamr_description.names import JOINTS, torque_sign
from hamr_description.numbers import value
from hamr_description.rates import SUBSTEPS, TARGET_HZ
from hamr_description.simple_constants import simple_constants
from hamr_dynamics.batch import BatchSim
from hamr_dynamics.effects.effects_file import EffectsFile, PlacedEffect
from hamr_dynamics.engine import ROWS, Engine
from hamr_sim_full.actuator import bender
from hamr_sim_full.engines import make_engine as make_full
from hamr_sim_full.mujoco_contact import set_contact
from hamr_sim_full.mujoco_loop import compiled_step_loop
from hamr_sim_residual.engines import make_engine as make_simple
from hamr_sim_residual.mlp import Mlp
from hamr_sim_residual.network import Network
from hamr_sim_residual.residual_plant import SHIPPED, residual_plant, torque_driven

ROUNDS, ROBOTS = 25, 256
TROT_HZ, AMPLITUDE = 10.0, 0.2  # strides per second, rad
ONE_STEP = "one 50 us substep of one robot, with leg law, one core"
#: One law that runs; kernels pass over the others.
EFFECTS = EffectsFile((PlacedEffect("cubic_stiffness", "cubic", JOINTS, {"cubic": 1e-3}),))
Round = Callable[[], int]  # one round; how many substeps of one robot it was


def trot(k: int) -> np.ndarray:
    """Target hip angles (8,) rad of period k."""
    turn = 2 * np.pi * TROT_HZ * k / TARGET_HZ
    phases = {"fl": 0.0, "rr": 0.0, "fr": np.pi, "rl": np.pi}
    angle = np.array([turn + phases[joint[:2]] + (0.5 * np.pi if joint.endswith("swing") else 0.0) for joint in JOINTS])
    side = np.array([1.0 if joint[1] == "l" else -1.0 for joint in JOINTS])
    return AMPLITUDE * side * np.sin(angle)


def batch(plant, dtype: str, n: int = ROBOTS, effects: EffectsFile | None = None) -> Round:
    """A batch of robots trotting; a round is five policy periods."""
    sim, count = BatchSim(plant, n, dtype=np.dtype(dtype), effects=effects), iter(range(10**9))

    def go() -> int:
        for _ in range(5):
            sim.step_targets(np.tile(trot(next(count)), (n, 1)))
        return 5 * SUBSTEPS * n

    return go


def mujoco_steps(xml: str) -> Round:
    """MuJoCo in a compiled loop; a round is five policy periods, the voltages of each those that trot about neutral."""
    model = mujoco.MjModel.from_xml_string(xml)
    set_contact(model)
    data, loop, count = mujoco.MjData(model), compiled_step_loop(), iter(range(10**9))
    mujoco.mj_resetDataKeyframe(model, data, model.key("stand").id)
    signs = np.array([torque_sign(joint) for joint in JOINTS])
    volts_per_rad = value("actuator.neutral_voltage") / value("controller.target_limit")

    def go() -> int:
        for _ in range(5):
            data.ctrl[:] = value("actuator.neutral_voltage") + signs * volts_per_rad * trot(next(count))
            loop(model._address, data._address, SUBSTEPS)
        return 5 * SUBSTEPS

    return go


def period(engine: Engine) -> Round:
    """One policy period of one robot behind the Engine interface: 80 times measure, law, substep."""
    sample, signs, count = np.zeros((len(ROWS), len(JOINTS))), np.array([torque_sign(joint) for joint in JOINTS]), iter(range(10**9))
    kp, kd, neutral = value("controller.kp"), value("controller.kd") / 1e3, value("actuator.neutral_voltage")

    def go() -> int:
        target = trot(next(count))
        for _ in range(SUBSTEPS):
            engine.measure(sample)
            engine.substep(np.clip(neutral + signs * (kp * (target - sample[0]) - kd * sample[1]), 0.0, 2.0 * neutral))
        return 1

    return go


def race(contenders: Mapping[str, Round], label: str, rounds: int = ROUNDS, clock: Callable[[], float] = thread_time) -> dict[str, float]:
    """Best time per unit of each contender, s, in rounds taken in turn."""
    best = dict.fromkeys(contenders, np.inf)
    for go in contenders.values():
        go()  # compiles, and leaves the start behind
    for _ in tqdm(range(rounds), desc=label, unit="round", disable=None):
        for name, go in contenders.items():
            start = clock()
            units = go()
            best[name] = min(best[name], (clock() - start) / units)
    return best


def random_network(scope: str) -> Network:
    """A tanh network with 2 hidden layers of 100, as the paper's: its weights do not matter to its speed."""
    law = Mlp(scope, (100, 100))
    return Network(law, np.random.default_rng(0).normal(0.0, 0.05, len(law.rows)))


def row(name: str, figure: float, unit: str, versus: str = "", ratio: float | None = None) -> dict:
    """One line of the report; ratio: how many times faster than `versus`."""
    return {"name": name, "value": figure, "unit": unit, "versus": versus, "ratio": ratio}


def bench() -> dict:
    """All rows: {rows: [{name, value, unit, versus, ratio}]}. Takes about a minute with warm kernels."""
    return {"rows": [*steps(), *_linear(), *_periods(), *_starts()]}


def steps() -> Iterator[dict]:
    """Rows of one substep; about half a minute with warm kernels."""
    law = bender()
    oracle = {
        "simple": mujoco_steps(mjcf.simple(simple_constants(), environment="ground")),
        "full": mujoco_steps(mjcf.full(c0=law.c0, c1=law.c1, environment="ground")),
    }
    plants = {
        "simple": "simple",
        "full": "full",
        "residual (shipped)": residual_plant(SHIPPED),
        "residual 2 x 100 whole robot": torque_driven(random_network("robot")),
        "residual 2 x 100 per leg": torque_driven(random_network("leg")),
    }
    kernels = {f"{name}, {dtype}": batch(plant, dtype) for name, plant in plants.items() for dtype in ("float64", "float32")}
    laws = {f"{name}, float64, with effects": batch(name, "float64", effects=EFFECTS) for name in oracle}
    best = race({f"MuJoCo {name}": go for name, go in oracle.items()} | kernels | laws, ONE_STEP)
    for name in oracle:
        yield row(f"substep, MuJoCo {name}", 1e6 * best[f"MuJoCo {name}"], "us")
    for name in kernels:
        versus = "MuJoCo simple" if name.startswith("simple") else "MuJoCo full"
        yield row(f"substep, kernel {name}", 1e6 * best[name], "us", versus, best[versus] / best[name])
    for name in laws:
        versus = name.removesuffix(", with effects")
        yield row(f"substep, kernel {name}", 1e6 * best[name], "us", f"kernel {versus}", best[versus] / best[name])


def _linear() -> Iterator[dict]:
    counts = (64, 256, 1024)
    best = race({str(n): batch("full", "float32", n) for n in counts}, "cost against robots", 10)
    for n in counts:
        yield row(f"substep, kernel full, float32, {n} robots", 1e6 * best[str(n)], "us", "64 robots", best["64"] / best[str(n)])


def _periods() -> Iterator[dict]:
    engines = {
        "kernel full": make_full(),
        "kernel simple": make_simple(),
        "kernel residual": make_simple(residual=str(SHIPPED)),
        "MuJoCo full": make_full(engine="mujoco"),
    }
    best = race({name: period(engine) for name, engine in engines.items()}, "policy period of one robot", 60)
    for name in engines:
        versus = "real time"
        yield row(f"policy period, {name}", 1e3 * best[name], "ms", versus, 1.0 / TARGET_HZ / best[name])


def _starts() -> Iterator[dict]:
    statements = {
        "import of hamr_dynamics.batch": "import hamr_dynamics.batch",
        "second start of the full kernel": "import numpy as np; from hamr_dynamics.batch import BatchSim; "
        "BatchSim('full', 64).step_targets(np.zeros((64, 8)))",
    }

    def start(code: str) -> Round:
        def go() -> int:
            subprocess.run([sys.executable, "-c", code], check=True)
            return 1

        return go

    best = race({name: start(code) for name, code in (statements | {"python": "pass"}).items()}, "starts", 5, perf_counter)
    for name in statements:
        yield row(name, best[name] - best["python"], "s")
