# SPDX-License-Identifier: MIT
"""The test vectors of tests/bindings/vectors, to the last bit of what the C program wrote in this run."""
import json
import os
import unittest

import numpy as np

import diffaqua as dq

with open(os.environ["DQA_VECTORS"], encoding="utf-8") as stream:
    VECTORS = json.load(stream)


def options(values):
    """JSON has one kind of number only."""
    return {name: int(value) if value == int(value) and name not in ("tolerance",) else value
            for name, value in values.items()}


def build(entry):
    space = dq.ShapeSpace(**options(entry["options"]))
    for base in entry.get("polygons", ()):
        space.add_polygon(np.reshape(base["corners"], (-1, 2)), base["name"])
    for base in entry.get("meshes", ()):
        space.add_mesh(np.reshape(base["vertices"], (-1, 3)), np.reshape(base["triangles"], (-1, 3)), base["name"])
    return space.build()


class Vectors(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.spaces = [build(entry) for entry in VECTORS["spaces"]]

    def same(self, found, entry, name):
        np.testing.assert_array_equal(np.ravel(found), np.ravel(entry[name]), err_msg=name)

    def test_helpers(self):
        entry = VECTORS["project_simplex"]
        self.same(dq.project_simplex(entry["x"]), entry, "result")
        entry = VECTORS["adam_step"]
        x, first, second = (np.array(entry[name]) for name in ("x", "first_moment", "second_moment"))
        dq.adam_step(x, entry["gradient"], entry["rates"], first, second, entry["iteration"])
        for name, found in (("x", x), ("first_moment", first), ("second_moment", second)):
            self.same(found, entry, name + "_after")

    def test_spaces(self):
        for space, entry in zip(self.spaces, VECTORS["spaces"]):
            self.same(space.density(entry["weights"]), entry, "density")
            bar = np.reshape(entry["density_bar"], space.shape)
            self.same(space.pullback(entry["weights"], bar), entry, "weights_bar")

    def test_rollouts(self):
        for entry in VECTORS["rollouts"]:
            simulator = dq.Simulator(self.spaces[entry["space"]], **options(entry["options"]))
            simulator.set_weights(entry["weights"])
            described = entry["controller"]
            if described["kind"] == "sinusoid":
                controller = dq.Sinusoid(1, simulator.time_step)
                controller.parameters = described["theta"]
            else:
                settings = options(described["options"])
                self.assertEqual(settings.pop("n_hidden"), 1)
                controller = dq.Perceptron(**{**settings, "hidden": [settings["hidden"]]})
                self.same(controller.parameters, described, "theta")
            terms = [dq.ObjectiveTerm(int(term["kind"]), weight=term["weight"]) for term in entry["terms"]]
            tape = dq.Tape(simulator)
            simulator.rollout(controller, entry["n_steps"], tape)
            loss, per_term = tape.objective(terms)
            q, v = simulator.state()
            for name, found in (("loss", loss), ("per_term", per_term), ("q", q), ("v", v),
                                ("sensors", simulator.sensors()), ("forces", simulator.forces())):
                self.same(found, entry, name)
            names = {"weights": dq.Wrt.WEIGHTS, "control": dq.Wrt.CONTROL, "actuation": dq.Wrt.ACTUATION,
                     "initial_position": dq.Wrt.INITIAL_POSITION, "material": dq.Wrt.MATERIAL}
            for name, gradient in zip(names, tape.gradient(terms, *names.values())):
                self.same(gradient, entry, "gradient_" + name)

    def test_optimisation(self):
        entry = VECTORS["optimisation"]
        simulator = dq.Simulator(self.spaces[entry["space"]], **options(entry["options"]))
        sine, tape, travel = dq.Sinusoid(1, simulator.time_step), dq.Tape(simulator), dq.ObjectiveTerm()
        n, x, losses, points = entry["n_bases"], np.array(entry["x"], dtype=float), [], []
        first, second = np.zeros_like(x), np.zeros_like(x)
        for iteration in range(1, entry["iterations"] + 1):
            tape.clear()
            simulator.set_weights(x[:n])
            sine.parameters = x[n:]
            simulator.rollout(sine, entry["n_steps"], tape)
            losses.append(tape.objective(travel)[0])
            gradient = np.concatenate(tape.gradient(travel, dq.Wrt.WEIGHTS, dq.Wrt.CONTROL))
            dq.adam_step(x, gradient, entry["rates"], first, second, iteration)
            x[:n] = dq.project_simplex(x[:n])
            x[n] = min(max(x[n], 0.0), 1.0)
            points.append(x.copy())
        self.same(losses, entry, "losses")
        self.same(points, entry, "x_after")
        self.assertLess(losses[-1], 2.0 * losses[0])

    def test_errors(self):
        simulator = dq.Simulator(self.spaces[0], **options(VECTORS["optimisation"]["options"]))
        for entry in VECTORS["errors"]:
            if entry["call"] == "step":
                simulator.set_weights([0.5, 0.5])
            with self.assertRaises(dq.DiffaquaError) as caught:
                getattr(simulator, entry["call"])(entry["argument"])
            found = caught.exception
            self.assertEqual((found.status, found.name, str(found)),
                             (entry["status"], entry["name"], entry["message"]))


if __name__ == "__main__":
    unittest.main(verbosity=1)
