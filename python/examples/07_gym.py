"""Trains a small policy to choose views, and compares it with random views on objects it never saw.

Needs the extra: pip install "./python[gym]". A policy of three weights is found by the cross-entropy method:
draw policies, keep the best, and draw around them.
"""

import gymnasium
import numpy as np
from numpy.typing import NDArray

import nextview.gym

TRAINING = [f"builtin:random-{i}" for i in range(8)]
HELD_BACK = [f"builtin:random-{i}" for i in range(100, 112)]
ROUNDS, POLICIES, KEPT = 3, 8, 2
Observation = nextview.gym.Observation


def environment(objects: list[str]) -> tuple[gymnasium.Env[Observation, np.int64], NDArray[np.float64]]:
    env = gymnasium.make("nextview/ViewPlanning-v0", objects=objects, n_candidates=30, views=4)
    planning = env.unwrapped
    assert isinstance(planning, nextview.gym.ViewPlanning)
    return env, planning.directions


def features(observation: Observation, directions: NDArray[np.float64]) -> NDArray[np.float64]:
    """By candidate: the unknown and the occupied voxels that lie towards it, and how far away the nearest
    view that was taken is."""
    grid = observation["map"]
    offsets = np.argwhere(np.ones_like(grid)) - (np.array(grid.shape) - 1) / 2
    towards = np.maximum(offsets @ directions.T / grid.shape[0], 0)
    unknown = (grid.ravel() == 0) @ towards
    occupied = (grid.ravel() == 2) @ towards
    taken = directions[observation["visited"] == 1]
    distance = np.arccos(np.clip(directions @ taken.T, -1, 1)).min(axis=1)
    columns = np.stack([unknown, occupied, distance], axis=1)
    scaled: NDArray[np.float64] = (columns - columns.mean(axis=0)) / (columns.std(axis=0) + 1e-9)
    return scaled


def coverage(
    env: gymnasium.Env[Observation, np.int64],
    directions: NDArray[np.float64],
    seed: int,
    weights: NDArray[np.float64] | None,
) -> float:
    """The coverage at the end of an episode, of this policy, or of random views where it is None."""
    rng = np.random.default_rng(seed)
    observation, info = env.reset(seed=seed)
    is_over = False
    while not is_over:
        if weights is None:
            action = rng.choice(np.flatnonzero(observation["visited"] == 0))
        else:
            action = np.argmax(features(observation, directions) @ weights - 1e9 * observation["visited"])
        observation, _, terminated, truncated, info = env.step(np.int64(action))
        is_over = terminated or truncated
    return float(info["coverage"])


env, directions = environment(TRAINING)
rng = np.random.default_rng(1)
mean, spread = np.zeros(3), np.ones(3)
for training in range(ROUNDS):
    policies = rng.normal(mean, spread, size=(POLICIES, 3))
    seeds = range(10 * training, 10 * training + 6)
    returns = [np.mean([coverage(env, directions, seed, policy) for seed in seeds]) for policy in policies]
    best = policies[np.argsort(returns)[-KEPT:]]
    mean, spread = best.mean(axis=0), best.std(axis=0) + 0.1
    print(f"round {training + 1}: coverage {np.mean(returns):.3f} on average, {max(returns):.3f} at best")

env, directions = environment(HELD_BACK)
seeds = range(1000, 1020)
learned = np.mean([coverage(env, directions, seed, mean) for seed in seeds])
random = np.mean([coverage(env, directions, seed, None) for seed in seeds])
print(f"held back: coverage {learned:.3f} learned, {random:.3f} random views")
assert learned > random
