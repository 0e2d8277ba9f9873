"""Scenes for tests."""

import numpy as np

import skillfold as sf


def quaternion(rng):
    q = rng.normal(size=4)
    return q / np.linalg.norm(q)


def pose(rng, reach=0.9):
    return np.concatenate([rng.uniform(-reach, reach, 3), quaternion(rng)])


def one_of_each(seed=0, count=2):
    """Shapes of every kind at random poses about a robot's base, each motionless."""
    rng = np.random.default_rng(seed)
    shapes = []
    for _ in range(count):
        shapes += [
            sf.Box(pose=pose(rng), size=rng.uniform(0.05, 0.4, 3)),
            sf.Sphere(center=rng.uniform(-0.9, 0.9, 3), radius=rng.uniform(0.05, 0.2)),
            sf.Cylinder(pose=pose(rng), radius=rng.uniform(0.05, 0.2), length=rng.uniform(0.1, 0.5)),
            sf.Capsule(pose=pose(rng), radius=rng.uniform(0.05, 0.1), length=rng.uniform(0.1, 0.5)),
            sf.Mesh(rng.uniform(-0.15, 0.15, (20, 3)), pose(rng)),
            sf.PointCloud(rng.uniform(-0.2, 0.2, (90, 3)), 0.02, pose(rng)),
        ]
    return sf.Scene(shapes)


def boxes(count, seed=0):
    rng = np.random.default_rng(seed)
    places = np.column_stack([rng.uniform(-0.8, 0.8, (count, 2)), rng.uniform(0, 1, count)])
    return sf.Scene([sf.Box(pose=place, size=rng.uniform(0.1, 0.3, 3)) for place in places])


def clear_poses(robot, obstacles, count, seed=0):
    """Random poses in which nothing touches."""
    q = robot.sample(20 * count, seed)
    return q[obstacles.clearance(q) > 1e-3][:count]
