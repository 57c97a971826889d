# SPDX-License-Identifier: MIT
"""diffaqua.torch: gradients by gradcheck, in a loop with an optimiser, and through a policy."""
import unittest

import numpy as np
import torch

import diffaqua as dq
import scene
from diffaqua.torch import RolloutLoss, SimulatorStep


def tensor(values, **settings):
    return torch.tensor(values, dtype=torch.float64, requires_grad=True, **settings)


class Rollouts(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.loss = RolloutLoss(scene.simulator(), dq.Sinusoid(1), 4, dq.ObjectiveTerm())

    def test_gradcheck(self):
        w, theta = tensor([0.9, 0.6]), tensor([0.7, 11.0, 0.3])
        scaled = lambda w, theta: 1e3 * self.loss(w, theta)
        self.assertTrue(torch.autograd.gradcheck(scaled, (w, theta), eps=1e-5, atol=1e-6, rtol=1e-6))

    def test_scale_of_w_does_not_matter(self):
        theta = tensor([0.7, 11.0, 0.3])
        w = tensor([0.9, 0.6])
        self.assertAlmostEqual(float(self.loss(w, theta)), float(self.loss(w * 7, theta)), delta=1e-14)
        self.loss(w, theta).backward()
        self.assertAlmostEqual(float(w.grad @ w), 0.0, delta=1e-14)

    def test_several_forwards_before_one_backward(self):
        w, theta = tensor([0.9, 0.6]), tensor([0.7, 11.0, 0.3])
        other = tensor([0.2, 0.8])
        (self.loss(w, theta) + 2.0 * self.loss(other, theta)).backward()
        both = w.grad.clone(), other.grad.clone()
        w.grad = other.grad = None
        self.loss(w, theta).backward()
        (2.0 * self.loss(other, theta)).backward()
        for found, alone in zip(both, (w.grad, other.grad)):
            np.testing.assert_array_equal(found, alone)

    def test_single_precision(self):
        w = torch.tensor([0.9, 0.6], requires_grad=True)
        loss = self.loss(w, torch.tensor([0.7, 11.0, 0.3]))
        loss.backward()
        self.assertEqual((loss.dtype, w.grad.dtype), (torch.float32, torch.float32))

    def test_types_are_promoted(self):
        theta = torch.tensor([0.7, 11.0, 0.3], dtype=torch.float64)
        exact = self.loss(torch.tensor([1.0, 1.0], dtype=torch.float64), theta)
        for w in (torch.tensor([1, 1]), torch.tensor([True, True]), torch.tensor([1, 1], dtype=torch.float16)):
            loss = self.loss(w, theta)
            self.assertEqual(loss.dtype, torch.float64)
            self.assertEqual(float(loss), float(exact))
        whole = self.loss(torch.tensor([1, 1]), torch.tensor([1, 11, 0]))
        self.assertEqual(whole.dtype, torch.get_default_dtype())
        self.assertNotEqual(float(whole), 0.0)
        with self.assertRaisesRegex(dq.ArgumentError, "real numbers, got torch.complex64"):
            self.loss(torch.tensor([1.0, 1.0j]), theta)

    def test_no_second_derivatives(self):
        w, theta = tensor([0.9, 0.6]), tensor([0.7, 11.0, 0.3])
        gradient, = torch.autograd.grad(self.loss(w, theta), w, create_graph=True)
        with self.assertRaisesRegex(dq.UnsupportedError, "second derivatives are not available"):
            gradient.sum().backward()

    def test_errors_pass(self):
        with self.assertRaisesRegex(dq.ArgumentError, "w: expected numbers >= 0"):
            self.loss(tensor([-1.0, 2.0]), tensor([0.7, 11.0, 0.3]))
        with self.assertRaises(dq.ArgumentError):
            self.loss(tensor([1.0, 2.0]), tensor([0.7, 11.0]))

    def test_without_gradient_nothing_is_recorded(self):
        with torch.no_grad():
            self.assertFalse(self.loss(tensor([0.9, 0.6]), tensor([0.7, 11.0, 0.3])).requires_grad)


class Steps(unittest.TestCase):
    def test_gradcheck(self):
        swimmer = scene.swimmer()
        for _ in range(2):
            swimmer.step([0.5])
        q, v = (tensor(values) for values in swimmer.state())
        direction = torch.tensor(np.random.default_rng(3).standard_normal((4, *q.shape)))
        step = SimulatorStep(swimmer)

        def along(a, b, actuation):
            """Directions of state space: all of it would take a difference for each node."""
            q_after, v_after = step(q.detach() + a * direction[0], v.detach() + b * direction[1], actuation)
            return 10.0 * (q_after * direction[2]).sum(), (v_after * direction[3]).sum()

        self.assertTrue(torch.autograd.gradcheck(along, (tensor(0.0), tensor(0.0), tensor([0.3])), eps=1e-6, atol=1e-5,
                                                 rtol=1e-6))

    def test_policy(self):
        """Three steps under a linear policy that lives in PyTorch: as the library's own closed loop."""
        swimmer = scene.swimmer()
        step, gain = SimulatorStep(swimmer), tensor(0.4)
        q, v = (torch.tensor(values) for values in swimmer.state())
        q0 = q
        for k in range(3):
            actuation = torch.tanh(gain * (1.0 + v.mean() + k)).reshape(1)
            q, v = step(q, v, actuation)
        loss = (q - q0)[:, 1].square().sum()
        loss.backward()
        self.assertTrue(np.isfinite(float(gain.grad)) and float(gain.grad) != 0.0)


if __name__ == "__main__":
    unittest.main(verbosity=1)
