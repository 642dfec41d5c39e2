"""The same run with all nodes in one process: real topics, and the servo bus is a plain call."""

from __future__ import annotations

from importlib import import_module

from hamr_controller.driver import LocalEnd
from hamr_controller.ros.process import new_node, spinning

from .executables import executables
from .graph import Run, graph


def composed(run: Run) -> dict:
    """Run until the simulator ends or the process is told to stop.

    Returns:
        simulated_s, wall_s, real_time_factor, counts.
    """
    with spinning() as spinner:
        made = {}
        for spec in reversed(graph(run)):  # the simulator last: it gets the driver
            module = import_module(executables()[spec.package, spec.executable])
            node, parameters = new_node(spec.name, module.Parameters, spec.parameters)
            spinner.add(node)
            if spec.ends_run:
                driver = made.get("leg_controller") or made["excitation"]
                driver.end = LocalEnd(driver.driver, driver.ready)
                made[spec.name] = module.make(node, parameters, spinner, driver.end)
            else:
                made[spec.name] = module.make(node, parameters, spinner)
        try:
            made["simulator"].run()
        finally:
            if "recorder" in made:
                made["recorder"].finish()
        return made["simulator"].summary()
