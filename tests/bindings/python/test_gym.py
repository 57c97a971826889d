# SPDX-License-Identifier: MIT
"""diffaqua.gym: the checker of Gymnasium, seeds, rewards."""
import unittest
import warnings

import gymnasium
import numpy as np
from gymnasium.utils.env_checker import check_env

import diffaqua as dq
import scene
from diffaqua.gym import SwimmerEnv


class Environment(unittest.TestCase):
    def test_checker(self):
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            check_env(SwimmerEnv(scene.simulator(), weights=[0.5, 0.5]), skip_render_check=True)
        # The range of velocities is not known; everything else the checker has to say counts.
        surprises = [str(entry.message) for entry in caught if issubclass(entry.category, UserWarning) and
                     "infinity" not in str(entry.message) and "spec" not in str(entry.message)]
        self.assertEqual(surprises, [])

    def test_seeds(self):
        env = SwimmerEnv(scene.simulator(), weights=[0.5, 0.5])
        first, _ = env.reset(seed=5)
        again, _ = env.reset(seed=5)
        other, _ = env.reset(seed=6)
        np.testing.assert_array_equal(first, again)
        self.assertTrue(np.any(first != other))

    def test_rewards_add_up_to_the_distance(self):
        env = SwimmerEnv(scene.simulator(), weights=[0.5, 0.5], max_steps=6, frame_skip=2, effort_weight=0.5, noise=0.0)
        env.reset(seed=1)
        total, truncated, info = 0.0, False, {}
        while not truncated:
            _, reward, terminated, truncated, info = env.step(np.array([np.sin(12.0 * info.get("time", 0.0))]))
            self.assertFalse(terminated)
            total += reward
        self.assertAlmostEqual(total, info["distance"] - 0.5 * info["effort"], delta=1e-12)
        self.assertAlmostEqual(info["time"], 12 / 30)

    def test_another_design(self):
        env = SwimmerEnv(scene.simulator(), weights=[0.5, 0.5])
        env.reset(seed=1, options={"weights": [1.0, 0.0]})
        np.testing.assert_array_equal(env.simulator.weights, [1.0, 0.0])

    def test_refused(self):
        with self.assertRaisesRegex(dq.ArgumentError, "no design"):
            SwimmerEnv(scene.simulator())
        with self.assertRaisesRegex(dq.ArgumentError, "render_mode"):
            SwimmerEnv(scene.swimmer(), render_mode="human")
        env = SwimmerEnv(scene.swimmer())
        env.reset()
        with self.assertRaisesRegex(dq.ArgumentError, "action: expected shape"):
            env.step([0.0, 0.0])

    def test_wrappers(self):
        env = gymnasium.wrappers.TimeLimit(SwimmerEnv(scene.swimmer()), 3)
        env.reset(seed=2)
        self.assertEqual([env.step(env.action_space.sample())[3] for _ in range(3)], [False, False, True])

    def test_environments_in_forked_processes(self):
        """As AsyncVectorEnv makes them where fork is the default: one in the parent, whose threads the workers lack."""
        def make():
            made = dq.Simulator(scene.space(cells_x=80, cells_y=32, threads=2), threads=2, **scene.SETTINGS)
            return SwimmerEnv(made, weights=[0.5, 0.5], max_steps=4)

        actions = np.array([[0.5], [-0.5]])
        together = gymnasium.vector.SyncVectorEnv([make] * 2)
        apart = gymnasium.vector.AsyncVectorEnv([make] * 2, context="fork")
        try:
            together.reset(seed=3)
            apart.reset_async(seed=3)
            apart.reset_wait(timeout=60)
            apart.step_async(actions)
            states, rewards, *_ = apart.step_wait(timeout=60)
            expected, paid, *_ = together.step(actions)
            np.testing.assert_array_equal(states, expected)
            np.testing.assert_array_equal(rewards, paid)
        finally:
            apart.close(terminate=True)
            together.close()


if __name__ == "__main__":
    unittest.main(verbosity=1)
