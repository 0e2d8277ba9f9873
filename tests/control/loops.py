"""A robot that does exactly as it is told, and is pushed by accelerations."""

import numpy as np

STEP = 1e-3


class Trace:
    """Commands and states of a run."""

    def __init__(self, commands, states, velocities):
        self.commands = commands
        self.states, self.velocities = np.array(states), np.array(velocities)
        self.modes = [command.mode for command in commands]
        self.references = np.array([command.reference for command in commands])
        self.accelerations = np.array([command.acceleration for command in commands])


def run(controller, start, seconds, push=None, change=None, rate=STEP):
    """Follow a controller's accelerations; `push(t)` adds to them, `change(t)` may do anything."""
    q, qd = np.array(start, float), np.zeros(len(start))
    commands, states, velocities = [], [], []
    for i in range(round(seconds / rate)):
        t = i * rate
        if change is not None:
            change(t)
        command = controller.command(t, q, qd)
        commands.append(command)
        states.append(q.copy())
        velocities.append(qd.copy())
        qd = qd + rate * (command.acceleration + (0.0 if push is None else push(t)))
        q = q + rate * qd
    return Trace(commands, states, velocities)


def pulse(start, end, acceleration):
    """A push as an acceleration between two times."""
    return lambda t: np.asarray(acceleration) if start <= t < end else np.zeros(len(acceleration))
