"""The gymnasium environment."""

from __future__ import annotations

import numpy as np
import pytest

import nextview

gymnasium = pytest.importorskip("gymnasium")
checker = pytest.importorskip("gymnasium.utils.env_checker")
gym = pytest.importorskip("nextview.gym")

OPTIONS = {"objects": ["builtin:mug", "builtin:bracket"], "n_candidates": 12, "views": 3}


@pytest.mark.filterwarnings("error")
def test_the_environment_is_one() -> None:
    checker.check_env(gymnasium.make("nextview/ViewPlanning-v0", **OPTIONS).unwrapped)


def test_episodes_follow_from_their_seed() -> None:
    env = gym.ViewPlanning(**OPTIONS)

    def episode(seed: int) -> list[float]:
        observation, info = env.reset(seed=seed)
        coverages = [info["coverage"]]
        truncated = False
        while not truncated:
            action = int(np.argmin(observation["visited"]))
            observation, reward, terminated, truncated, info = env.step(action)
            assert not terminated and env.observation_space.contains(observation)
            assert reward == info["coverage"] - coverages[-1] >= 0
            coverages.append(info["coverage"])
        return coverages

    first = episode(1)
    assert len(first) == OPTIONS["views"] and episode(1) == first
    assert any(episode(seed) != first for seed in range(2, 6))


def test_a_view_taken_before_adds_nothing() -> None:
    env = gym.ViewPlanning(**OPTIONS)
    before, info = env.reset(seed=3, options={"object": "builtin:mug"})
    assert info["object"] == "builtin:mug"
    first = int(np.argmax(before["visited"]))
    after, reward, *_ = env.step(first)
    assert reward == 0 and (after["map"] == before["map"]).all()


def test_a_wrong_environment_is_refused() -> None:
    for name in ("n_candidates", "views", "cells"):
        with pytest.raises(nextview.InputError, match=f"`{name}` is 1, expected 2 to"):
            gym.ViewPlanning(**{name: 1})
    with pytest.raises(nextview.InputError, match="`objects` is empty"):
        gym.ViewPlanning([])
    with pytest.raises(nextview.InputError, match=r"`objects` is 'builtin:mug', expected a list, such as \["):
        gym.ViewPlanning("builtin:mug")
    env = gym.ViewPlanning(["builtin:no-such"])
    with pytest.raises(nextview.NextviewError, match="no built-in object"):
        env.reset(seed=1)
    env = gym.ViewPlanning(["builtin:mug"], n_candidates=5)
    env.reset(seed=1)
    with pytest.raises(nextview.InputError, match="expected 0 to 4"):
        env.step(5)


def test_an_object_that_cannot_be_had_leaves_the_episode_as_it_is() -> None:
    env = gym.ViewPlanning(**OPTIONS)
    env.reset(seed=1, options={"object": "builtin:mug"})
    with pytest.raises(nextview.NextviewError, match="no built-in object"):
        env.reset(seed=1, options={"object": "builtin:no-such"})
    *_, info = env.step(3)
    assert info["object"] == "builtin:mug"
