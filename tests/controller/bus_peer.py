"""One end of a servo bus as a process of its own: bus_peer.py driver|simulator RUN VOLTS; says what happens, line by line.

What goes on as before is not said again: nobody may be reading, and a full pipe would stop the peer.
"""

from __future__ import annotations

import sys

import numpy as np

from hamr_controller.bus_ends import DriverEnd, Progress, Reply, SimulatorEnd
from hamr_controller.plan import Plan


def say(*words: object) -> None:
    sys.stdout.write(" ".join(map(str, words)) + "\n")
    sys.stdout.flush()


def driver(run: str, volts: float) -> None:
    """Holds a voltage in every period, whatever simulator comes."""
    end, out, plan, said = DriverEnd(run), np.zeros((80, 8)), Plan.open_loop(np.full((80, 8), volts)), None
    while True:
        if not end.joined:
            if not end.connect():
                continue
            end.join()
            say("joined")
            said = None
        period = end.next_period()
        if period is None:
            continue
        while (progress := end.drive(period, plan, out)) is Progress.PENDING:
            pass
        if progress is not said:
            say(progress.name, period)
        said = progress


def simulator(run: str, volts: float) -> None:
    """Offers period after period; the sample that driver answers holds the period's number."""
    end, sample, out = SimulatorEnd(run, patience_s=0.1), np.zeros((7, 8)), np.zeros(8)
    say("made")
    period, said = 0, None
    while True:
        end.offer(period, sample)
        while (reply := end.poll(out)) is Reply.WAITING:
            pass
        for k in range(1, 80):
            end.answer(k, sample, out)
        if reply is not said:
            say(reply.name, period, out[0])
        period, said = period + 1, reply


if __name__ == "__main__":
    {"driver": driver, "simulator": simulator}[sys.argv[1]](sys.argv[2], float(sys.argv[3]))
