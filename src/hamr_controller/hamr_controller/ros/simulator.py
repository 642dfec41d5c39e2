"""The simulator node, whatever the robot inside: state out, servo bus, clock, services."""

from __future__ import annotations

import json
from pathlib import Path
from time import monotonic

from rclpy.node import Node
from std_srvs.srv import SetBool, Trigger

from hamr_description.names import Topic
from hamr_description.rates import TARGET_MS

from ..bus_ends import Reply, SimulatorEnd
from ..health import Level
from ..messages import StateMessages, announcements
from ..simulation import End, Pace, Simulation
from .parameters import follow
from .ports import Diagnostics, Publishers
from .process import Spinner
from .run import DRIVER, RECORDER
from .simulator_parameters import SimulatorParameters

_RESEND_S = 0.05  # wall time after which a state that was not answered is sent again
_SERVE_S = 0.02  # services are looked after this often, not in every period
_SETTLE_S, _HASTY_SETTLE_S = 2.0, 0.5  # for listeners to get the last messages


class SimulatorNode:
    """Runs a Simulation behind the topics.

    Args:
        node: the node.
        parameters: its parameters.
        spinner: runs its callbacks.
        engine: the robot (architecture.md, Engine).
        end: the simulator's end of the bus; default one between processes.
    """

    def __init__(self, node: Node, parameters: SimulatorParameters, spinner: Spinner, engine, end: End | None = None):
        self._parameters, self._spinner = parameters, spinner
        self._diagnostics = Diagnostics(node)
        self._health = self._diagnostics.health
        self._messages = StateMessages(parameters.samples_per_frame)
        self._latched = Publishers(node, [Topic.RUN_INFO, Topic.ROBOT_DESCRIPTION])
        self._publishers = Publishers(node, [Topic.CLOCK, Topic.ODOM, Topic.JOINT_STATES, Topic.SERVO_JOINTS, Topic.SERVO_ACTUATORS])
        self._end = end or SimulatorEnd(parameters.run)
        self._simulation = Simulation(engine, self._end, seed=parameters.seed)
        self._pace = Pace(parameters.real_time_factor)
        self._paused, self._steps, self._reset = False, 0, False
        self._broken = False  # whether the state is beyond repair but by a reset
        self._driven = False  # whether a driver was ever there
        self._state: dict[str, bytes] = {}
        self._servo: dict[str, bytes] = {}
        self._began = self._served = self._reported = monotonic()
        self._reported_period = 0
        node.create_service(Trigger, "~/reset", self._on_reset)
        node.create_service(Trigger, "~/step", self._on_step)
        node.create_service(SetBool, "~/pause", self._on_pause)
        follow(node, parameters, lambda new: self._pace.set(new.real_time_factor))

    def run(self) -> None:
        """Simulate until the process is to stop, or the duration is over."""
        try:
            self._announce()
            self._await_recorder()
            while not self._spinner.stopping and self._simulation.period < self._parameters.periods:
                self._observe()
                if self._may_run():
                    self._run_period()
                elif self._reset:
                    self._reset = self._broken = False
                    self._simulation.reset()
            self._send(self._servo)
        finally:
            self._end.close()
        if self._parameters.report:
            Path(self._parameters.report).write_text(json.dumps(self.summary()))
        self._publishers.settle(_HASTY_SETTLE_S if self._spinner.stopping else _SETTLE_S)

    def summary(self) -> dict:
        """How the run went: simulated_s, wall_s, real_time_factor, counts."""
        simulated = self._simulation.time_ns / 1e9
        wall = monotonic() - self._began
        counts = {**self._health.counts, **self._simulation.engine.counters()}
        return {"simulated_s": simulated, "wall_s": wall, "real_time_factor": simulated / wall, "counts": counts}

    def _announce(self) -> None:
        p = self._parameters
        said = announcements(self._simulation.engine, p.samples_per_frame, p.seed, json.loads(p.excitation or "{}"))
        for topic, raw in said.items():
            self._latched.send(topic, raw)

    def _await_recorder(self) -> None:
        while RECORDER in self._parameters.awaited and not self._publishers.recorder_listens() and not self._spinner.stopping:
            self._health.state("recorder", Level.WARN, "Time starts when a recorder listens.")
            self._serve(_SERVE_S)
        self._health.state("recorder", Level.OK, "")
        self._pace.resume()

    def _observe(self) -> None:
        """Publish the state at the start of the period, and after it, while the policy thinks, the samples of the period before."""
        simulation = self._simulation
        if not simulation.measure():
            self._health.state("state", Level.ERROR, f"The robot's state is not finite at {simulation.time_ns / 1e9:.3f} s: reset it.")
            self._broken = True
            return
        simulation.offer()
        self._state = self._messages.state(simulation.time_ns, simulation.samples[0], simulation.base)
        self._send(self._state)
        self._send(self._servo)
        self._servo = {}

    def _may_run(self) -> bool:
        """Wait until the period is answered, due and not held back; False if the process is to stop or a reset is due first."""
        volts, began = self._simulation.volts[0], monotonic()
        sent = began
        while not (self._spinner.stopping or self._reset):
            if self._broken or (self._paused and not self._steps):
                self._serve(_SERVE_S)
                self._pace.resume()
                began = monotonic()
                continue
            reply, now = self._end.poll(volts), monotonic()
            if reply is Reply.WAITING and now - began > self._parameters.driver_patience:
                self._end.give_up(volts)
            elif reply is Reply.WAITING or (reply is Reply.ABSENT and self._awaits_driver):
                if now - sent > _RESEND_S:
                    self._send(self._state)  # lost or not, a state is answered the same way however often it comes
                    sent = now
                self._serve(0.0 if reply is Reply.WAITING and self._end.waits else _SERVE_S)
            elif (remaining := self._pace.remaining()) > 0:
                self._serve(remaining)
            else:
                self._note_driver(reply is Reply.READY)
                return True
        return False

    @property
    def _awaits_driver(self) -> bool:
        return DRIVER in self._parameters.awaited and not self._driven

    def _note_driver(self, there: bool) -> None:
        self._driven |= there
        if there:
            self._health.state("driver", Level.OK, f"{self._end.driver_name} drives.")
        elif self._driven:
            self._health.state("driver", Level.WARN, f"{self._end.driver_name} is gone or silent: neutral voltage until one joins.")
        else:
            self._health.state("driver", Level.WARN, "No driver on the servo bus: neutral voltage.")

    def _run_period(self) -> None:
        time_ns = self._simulation.time_ns
        if time_ns == 0:
            self._began = monotonic()
        self._pace.advance()
        self._steps = max(0, self._steps - 1)
        self._simulation.run()
        if not self._end.present:
            self._health.counts["periods at neutral voltage"] += 1
            self._note_driver(False)
        self._servo = self._messages.servo(time_ns, self._simulation.samples)
        if RECORDER in self._parameters.awaited:
            self._publishers.keep_pace()
        if monotonic() - self._served > _SERVE_S:
            self._serve(0.0)

    def _send(self, messages: dict[str, bytes]) -> None:
        for topic, raw in messages.items():
            self._publishers.send(topic, raw)

    def _serve(self, seconds: float) -> None:
        """Look after services, parameters and diagnostics for a while."""
        self._spinner.once(seconds)
        self._served = monotonic()
        self._diagnostics.tick(self._simulation.time_ns, self._report)

    def _report(self) -> None:
        now, period = monotonic(), self._simulation.period
        figures = self._health.figures
        figures["real-time factor"] = (period - self._reported_period) * TARGET_MS * 1e-3 / max(1e-9, now - self._reported)
        figures["overruns"] = self._pace.overruns
        figures.update(self._simulation.engine.counters())
        self._reported, self._reported_period = now, period

    def _on_reset(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._reset = True
        self._health.state("state", Level.OK, "")
        response.success, response.message = True, "The robot starts anew; sim time goes on."
        return response

    def _on_step(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._steps += self._paused
        response.success = self._paused
        response.message = f"One period of {TARGET_MS:g} ms." if self._paused else "Pause the simulator first."
        return response

    def _on_pause(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        self._paused, self._steps = request.data, 0
        response.success, response.message = True, "Paused." if self._paused else "Running."
        return response
