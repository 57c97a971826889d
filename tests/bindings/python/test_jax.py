# SPDX-License-Identifier: MIT
"""diffaqua.jax: gradients against differences, under jit and vmap, and what is refused."""
import unittest

import jax
import jax.numpy as jnp
import numpy as np

import diffaqua as dq
import scene
from diffaqua.jax import rollout_loss, simulator_step

jax.config.update("jax_enable_x64", True)

W, THETA = np.array([0.9, 0.6]), np.array([0.7, 11.0, 0.3])


class Rollouts(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.loss = staticmethod(rollout_loss(scene.simulator(), dq.Sinusoid(1), 4, dq.ObjectiveTerm()))

    def test_gradient(self):
        for function in (jax.grad(self.loss, (0, 1)), jax.jit(jax.grad(self.loss, (0, 1)))):
            by_w, by_theta = function(W, THETA)
            direction_w, direction_theta, h = np.array([0.3, -0.4]), np.array([0.1, 0.5, -0.6]), 1e-5
            slope = (self.loss(W + h * direction_w, THETA + h * direction_theta) -
                     self.loss(W - h * direction_w, THETA - h * direction_theta)) / (2 * h)
            found = by_w @ direction_w + by_theta @ direction_theta
            self.assertAlmostEqual(float(found / slope), 1.0, delta=1e-6)

    def test_value_is_that_of_the_gradient(self):
        value, _ = jax.value_and_grad(self.loss)(W, THETA)
        self.assertEqual(float(value), float(self.loss(W, THETA)))

    def test_vmap(self):
        many = jnp.stack([W, W[::-1], W * 2.0])
        values = jax.vmap(self.loss, (0, None))(many, THETA)
        gradients = jax.vmap(jax.grad(self.loss), (0, None))(many, THETA)
        for w, value, gradient in zip(many, values, gradients):
            self.assertEqual(float(value), float(self.loss(w, THETA)))
            np.testing.assert_array_equal(gradient, jax.grad(self.loss)(w, THETA))

    def test_single_precision(self):
        loss, gradient = jax.value_and_grad(self.loss)(jnp.asarray(W, jnp.float32), jnp.asarray(THETA, jnp.float32))
        self.assertEqual((loss.dtype, gradient.dtype), (jnp.float32, jnp.float32))

    def test_no_second_derivatives(self):
        with self.assertRaisesRegex(dq.UnsupportedError, "second derivatives are not available"):
            jax.grad(lambda w: jax.grad(self.loss)(w, THETA).sum())(W)

    def test_errors_pass(self):
        with self.assertRaisesRegex(Exception, "w: expected numbers >= 0"):
            jax.block_until_ready(self.loss(-W, THETA))

    def test_types(self):
        """Whole numbers are taken as numbers; complex ones are refused, not cut."""
        whole = self.loss(jnp.array([1, 0]), THETA)
        self.assertEqual(whole.dtype, self.loss(jnp.array([1.0, 0.0]), THETA).dtype)
        self.assertEqual(float(whole), float(self.loss(jnp.array([1.0, 0.0]), THETA)))
        with self.assertRaisesRegex(TypeError, "complex"):
            self.loss(jnp.array([1.0 + 1.0j, 0.0]), THETA)


class Steps(unittest.TestCase):
    def test_gradient_through_a_loop(self):
        swimmer = scene.swimmer()
        step, (q0, v0) = jax.jit(simulator_step(swimmer)), swimmer.state()
        weight = np.random.default_rng(2).standard_normal(q0.shape)

        def loss(gain):
            q, v = q0, v0
            for k in range(3):
                q, v = step(q, v, jnp.tanh(gain * (1.0 + v.mean() + k)).reshape(1))
            return jnp.sum(weight * q) + jnp.sum(weight * v)

        h = 1e-5
        slope = (loss(0.4 + h) - loss(0.4 - h)) / (2 * h)
        self.assertAlmostEqual(float(jax.grad(loss)(0.4) / slope), 1.0, delta=1e-6)
        with self.assertRaisesRegex(dq.UnsupportedError, "second derivatives"):
            jax.grad(jax.grad(loss))(0.4)


if __name__ == "__main__":
    unittest.main(verbosity=1)
