"""The same run without ROS: one process, no topics, bit for bit the same numbers as the graph of nodes."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from time import monotonic

import numpy as np

from hamr_bags.excitation import excitation
from hamr_bags.recorder import Recorder
from hamr_controller.driver import Driver, LocalEnd
from hamr_controller.health import Health
from hamr_controller.law import Gains
from hamr_controller.leg_controller import LegController
from hamr_controller.messages import StateMessages, TargetMessages, VoltageMessages, announcements
from hamr_controller.plan import Plan
from hamr_controller.player import Player
from hamr_controller.simulation import Simulation
from hamr_controller.targets import Targets
from hamr_description.errors import ConfigError
from hamr_description.names import JOINTS, Topic
from hamr_description.rates import TARGET_HZ, TARGET_NS
from hamr_policy.pilot import Pilot, command_named, load

from .graph import Run

Publish = Callable[[str, bytes], None]


class Steered:
    """A Driver that is policy and leg controller at once."""

    def __init__(self, pilot: Pilot, controller: LegController, simulation: Callable[[], Simulation], publish: Publish):
        """Args: simulation, gives the one to steer; publish, takes topic and message."""
        self._pilot, self._controller, self._simulation, self._publish = pilot, controller, simulation, publish
        self._messages = TargetMessages()

    def plan(self, period: int) -> Plan | None:
        """See Driver."""
        simulation, time_ns = self._simulation(), period * TARGET_NS
        target = self._pilot.answer(time_ns, simulation.samples[0], simulation.base)
        self._publish(Topic.LEG_TARGETS, self._messages.targets(time_ns, target))
        self._controller.hear(JOINTS, target, time_ns, period)
        return self._controller.plan(period)

    def done(self, period: int, volts: np.ndarray) -> None:
        """See Driver."""
        self._controller.done(period, volts)


def make_engine(run: Run):
    """The engine of a run, as the simulator nodes make it."""
    options = {"engine": run.engine, "environment": run.environment, "friction": run.friction, "effects": run.effects}
    options["seed"] = run.seed
    if run.backend == "full":
        from hamr_sim_full import engines as full  # each only where it is asked for

        return full.make_engine(**options)
    from hamr_sim_residual import engines as simple

    return simple.make_engine(backend=run.backend, residual=run.residual, **options)


def direct(run: Run, *, engine=None) -> dict:
    """Run without ROS.

    Args:
        run: with `seconds`; `real_time_factor` does not count.
        engine: in place of the one that `run` names.

    Returns:
        simulated_s, wall_s, real_time_factor, counts.

    Raises:
        ConfigError: the run has no end, or a file with parameters of nodes.
    """
    if not run.seconds > 0:
        raise ConfigError("A run without ROS needs an end: give its seconds.")
    if run.parameters:
        raise ConfigError(f"A run without ROS has no nodes to give '{run.parameters}' to; leave the parameter file out.")
    with ExitStack() as stack:
        write = stack.enter_context(Recorder(run.bag)).write if run.bag else lambda topic, raw: None
        health = Health(lambda level, sentence: None)
        simulation = _simulation(run, engine or make_engine(run), health, write)
        states = StateMessages(run.samples_per_frame)
        for topic, raw in announcements(simulation.engine, run.samples_per_frame, run.seed, run.excitation).items():
            write(topic, raw)
        began = monotonic()
        while simulation.period < round(run.seconds * TARGET_HZ):
            time_ns = simulation.time_ns
            if not simulation.measure():
                raise ConfigError(f"The robot's state is not finite at {time_ns / 1e9:.3f} s; change the run.")
            simulation.offer()
            simulation.end.poll(simulation.volts[0])
            _write_all(write, states.state(time_ns, simulation.samples[0], simulation.base))
            simulation.run()
            _write_all(write, states.servo(time_ns, simulation.samples))
        wall = monotonic() - began
    counts = {**health.counts, **simulation.engine.counters()}
    return {"simulated_s": run.seconds, "wall_s": wall, "real_time_factor": run.seconds / wall, "counts": counts}


def _simulation(run: Run, engine, health: Health, write: Publish) -> Simulation:
    messages = VoltageMessages(run.samples_per_frame)

    def publish(time_ns: int, volts: np.ndarray) -> None:
        write(Topic.SERVO_VOLTAGES, messages.voltages(time_ns, volts))

    driver: Driver
    if run.excitation:
        driver = Player(excitation(**run.excitation), health, publish)
    else:
        targets = Targets(lockstep=False, patience_s=0.0, age_s=0.0)
        controller = LegController(targets, Gains.default(), health, publish)
        pilot = Pilot(load(run.policy), silence_s=0.0, command=command_named(run.command))
        driver = Steered(pilot, controller, lambda: simulation, write) if run.policy else controller
    simulation = Simulation(engine, LocalEnd(driver), seed=run.seed)
    return simulation


def _write_all(write: Publish, messages: dict[str, bytes]) -> None:
    for topic, raw in messages.items():
        write(topic, raw)
