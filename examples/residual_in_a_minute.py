"""From white noise to a residual model: 1 s of passive data of HAMR-full, no ROS, and how much closer the model gets."""

import tempfile
from pathlib import Path

import numpy as np

from hamr_bags.excitation import excitation
from hamr_bags.reader import load
from hamr_bringup.direct import direct
from hamr_bringup.graph import Run
from hamr_dynamics.batch import BatchSim
from hamr_sim_residual.residual_plant import residual_plant
from hamr_sim_residual.train import train

with tempfile.TemporaryDirectory() as folder:
    noise = excitation("noise", seconds=1.0, seed=1)
    bag = Path(folder, "noise")
    direct(
        Run(backend="full", environment="suspended", excitation=noise.parameters, bag=str(bag), seconds=1.0, samples_per_frame=80)
    )
    model = train([load(bag)], Path(folder, "residual.json"), progress=False)["model"]

    test = excitation("noise", seconds=1.0, seed=2).voltages[None]  # another seed
    robot = BatchSim("full", 1, environment="suspended")
    truth = robot.step_voltages(test, record=True)
    start, stop = 16_000, 16_160  # 8 ms from the middle, from the robot's own state
    for name, plant in {"HAMR-simple": "simple", "with residual": residual_plant(model)}.items():
        sim = BatchSim(plant, 1, environment="suspended")
        sim.set_state(q=truth["q"][:, start], qd=truth["qd"][:, start])
        run = sim.step_voltages(test[:, start:stop], record=True)
        error = np.sqrt(np.mean((run["q"] - truth["q"][:, start:stop]) ** 2))
        print(f"{name}: {np.degrees(error):.2g} degrees rms from HAMR-full over 8 ms")
