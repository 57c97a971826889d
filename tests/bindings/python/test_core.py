# SPDX-License-Identifier: MIT
"""The package over the C interface: arrays, errors, lives of objects, callbacks, threads."""
import dataclasses
import gc
import os
import re
import subprocess
import sys
import tempfile
import threading
import typing
import unittest
import weakref

import numpy as np

import diffaqua as dq
import scene
from diffaqua import _library, constants, structs

TRAVEL = dq.ObjectiveTerm()


class Declarations(unittest.TestCase):
    """What Python declares a second time is what the header says."""

    def test_constants(self):
        for kind, prefix in constants.PREFIXES.items():
            expected = {name[len(prefix):]: getattr(_library.lib, name) for name in dir(_library.lib)
                        if name.startswith(prefix)}
            self.assertEqual({entry.name: entry.value for entry in kind}, expected, prefix)
        covered = tuple(constants.PREFIXES.values()) + ("DQA_VERSION_", "DQA_ABI_", "DQA_ERROR_", "DQA_SUCCESS",
                                                        "DQA_NOT_CONVERGED", "DQA_DIVERGED", "DQA_CANCELLED")
        self.assertEqual([name for name in dir(_library.lib) if name.startswith("DQA_") and
                          not name.startswith(covered)], [])

    def test_structs(self):
        pointers = {"dqa_shape_space_options": {"cancel"}, "dqa_simulator_options": {"cancel"},
                    "dqa_mlp_options": {"n_hidden"}, "dqa_objective_term": {"kind", "path", "n_path"}}
        for kind, struct in structs.STRUCTS.items():
            own = ([field.name for field in dataclasses.fields(kind)] if dataclasses.is_dataclass(kind)
                   else list(typing.get_type_hints(kind)))
            expected = [name for name in structs.visible_fields(struct) if name not in pointers.get(struct, ())]
            self.assertEqual(own, expected, struct)

    def test_errors(self):
        for name in dir(_library.lib):
            if name.startswith("DQA_ERROR_") or name in ("DQA_NOT_CONVERGED", "DQA_DIVERGED", "DQA_CANCELLED"):
                kind = dq.errors.BY_STATUS[getattr(_library.lib, name)]
                self.assertEqual(kind.name, name)
                self.assertTrue(issubclass(kind, dq.DiffaquaError))

    def test_every_function_is_used(self):
        folder = os.path.dirname(dq.__file__)
        text = ""
        for name in os.listdir(folder):
            if name.endswith(".py"):
                with open(os.path.join(folder, name), encoding="utf-8") as file:
                    text += file.read()
        unused = [name for name in dir(_library.lib) if name.startswith("dqa_") and name not in text]
        # The message says more; the info has it.
        self.assertEqual(unused, ["dqa_controller_n_parameters", "dqa_status_text"])


class Arrays(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.swimmer = scene.swimmer()

    def test_no_copy(self):
        array = np.ones((3, 2))
        self.assertIs(dq.optimize.numbers("x", array, (None, 2)), array)

    def test_conversions(self):
        expected = self.swimmer._n_cells
        self.assertEqual(expected, 160)
        for weights in ([1, 0], (np.float32(1.0), 0), np.array([1, 7, 0, 7], dtype=np.int8)[::2]):
            self.swimmer.set_weights(weights)
            np.testing.assert_array_equal(self.swimmer.weights, [1.0, 0.0])

    def test_refused(self):
        for weights, message in (([[0.5, 0.5]], r"weights: expected shape \[any\], got \[1, 2\]"),
                                 (["a", "b"], "weights: expected real numbers, got <U1"),
                                 ([1j, 0], "weights: expected real numbers, got complex128"),
                                 ([[1.0], [1.0, 2.0]], "weights: expected numbers of shape"),
                                 ([0.3, 0.3], "weights sum to 0.6"), ([float("nan"), 1.0], "weights"),
                                 ([1.0], "weights"), ([], "weights")):
            with self.assertRaisesRegex(dq.ArgumentError, message):
                self.swimmer.set_weights(weights)
        with self.assertRaisesRegex(dq.ArgumentError, "nodes: expected whole numbers, got float64"):
            self.swimmer.set_fixed_nodes([1.5])
        with self.assertRaisesRegex(dq.ArgumentError, "nodes: expected numbers of 32 bits"):
            self.swimmer.set_fixed_nodes([2**40])

    def test_outputs(self):
        self.swimmer.set_weights([0.5, 0.5])
        q, v = self.swimmer.state()
        again = np.empty_like(q), np.empty_like(v)
        result = self.swimmer.state(*again)
        self.assertIs(result[0], again[0])
        np.testing.assert_array_equal(again[0], q)
        for wrong, message in ((np.empty(q.shape, np.float32), "float32"), (np.empty(q.shape[::-1]).T, "C-contiguous"),
                               (q[:-1], r"\[\d+, 2\], got float64"), ([], "expected a NumPy array")):
            with self.assertRaisesRegex(dq.ArgumentError, message):
                self.swimmer.state(wrong)
        frozen = np.empty_like(q)
        frozen.flags.writeable = False
        with self.assertRaisesRegex(dq.ArgumentError, "writeable"):
            self.swimmer.state(frozen)

    def test_options(self):
        with self.assertRaisesRegex(TypeError, "unknown option 'sigmoid'; expected one of .*sigma"):
            dq.ShapeSpace(sigmoid=1)
        with self.assertRaises(dq.ArgumentError):
            dq.ShapeSpace(sigma=-1.0)
        with self.assertRaisesRegex(dq.ArgumentError, "cells_x"):
            dq.ShapeSpace(cells_x="many")
        with self.assertRaisesRegex(dq.ArgumentError, "current: expected 3 numbers"):
            dq.Simulator(scene.space(), current=[1.0])


class Errors(unittest.TestCase):
    def test_status_and_message(self):
        with self.assertRaises(dq.AccessError) as caught:
            dq.ShapeSpace().add_mesh_file("/nowhere/fish.stl")
        self.assertEqual((caught.exception.status, caught.exception.name), (-4, "DQA_ERROR_IO"))
        self.assertIn("fish.stl", str(caught.exception))
        self.assertIsInstance(caught.exception, OSError)
        with self.assertRaises(dq.MeshError):
            dq.ShapeSpace().add_mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
        with self.assertRaises(dq.StateError):
            scene.simulator().step([0.0])
        with tempfile.NamedTemporaryFile() as file, self.assertRaises(dq.FileError):
            dq.ShapeSpace.load(file.name)

    def test_failed_creation_leaves_nothing(self):
        with self.assertRaises(dq.StateError):
            dq.Simulator(dq.ShapeSpace())
        with self.assertRaises(dq.ArgumentError):
            dq.Sinusoid(0)


class Lives(unittest.TestCase):
    def test_any_order(self):
        for order in ("space simulator sine tape adjoint", "adjoint tape sine simulator space",
                      "tape space adjoint simulator sine"):
            objects = {"space": scene.space()}
            objects["simulator"] = dq.Simulator(objects["space"], **scene.SETTINGS)
            objects["simulator"].set_weights([0.5, 0.5])
            objects["sine"] = dq.Sinusoid(1)
            objects["tape"] = dq.Tape(objects["simulator"])
            objects["simulator"].rollout(objects["sine"], 3, objects["tape"])
            objects["adjoint"] = dq.Adjoint(objects["tape"])
            objects["adjoint"].seed_objective(TRAVEL)
            for name in order.split():
                objects[name].close()
                objects[name].close()
                with self.assertRaisesRegex(dq.StateError, "is closed"):
                    objects[name].info() if hasattr(objects[name], "info") else objects[name]._use().__enter__()

    def test_child_outlives_parents(self):
        swimmer, sine = scene.swimmer(), dq.Sinusoid(1)
        tape = dq.Tape(swimmer)
        swimmer.rollout(sine, 3, tape)
        adjoint = dq.Adjoint(tape)
        swimmer.close(), sine.close(), tape.close()
        adjoint.seed_objective(TRAVEL)
        adjoint.backward()
        self.assertTrue(np.any(adjoint.gradient(dq.Wrt.WEIGHTS)))

    def test_collected(self):
        swimmer = scene.swimmer()
        watch = weakref.ref(swimmer)
        del swimmer
        gc.collect()
        self.assertIsNone(watch())

    def test_with(self):
        with dq.Sinusoid(1) as sine:
            self.assertFalse(sine.closed)
        self.assertTrue(sine.closed)
        self.assertIn("closed", repr(sine))

    def test_not_closed_in_use(self):
        swimmer = scene.swimmer()

        def close(_done, _total):
            swimmer.close()

        with self.assertRaisesRegex(dq.StateError, "cannot be closed while"):
            swimmer.rollout(dq.Sinusoid(1), 3, progress=close)
        swimmer.close()

    def test_not_pickled(self):
        import pickle
        with self.assertRaisesRegex(TypeError, "cannot be pickled"):
            pickle.dumps(dq.Sinusoid(1))

    def test_interpreter_may_end_at_any_moment(self):
        program = ("import scene, diffaqua as dq\nkeep = scene.swimmer(); tape = dq.Tape(keep)\n"
                   "keep.rollout(dq.CallbackController(lambda *a: [0.5], n_signals=1), 2, tape)\n"
                   "dq.set_log_handler(print)\n")
        done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
        self.assertEqual((done.returncode, done.stderr), (0, ""))


class Callbacks(unittest.TestCase):
    def test_progress(self):
        seen = []
        swimmer = scene.swimmer()
        swimmer.rollout(dq.Sinusoid(1), 4, progress=lambda done, total: seen.append((done, total)))
        self.assertEqual(seen[-1], (4, 4))
        with self.assertRaises(dq.CancelledError):
            swimmer.rollout(dq.Sinusoid(1), 9, progress=lambda done, total: done == 2)
        self.assertEqual(swimmer.info().steps, 6)
        with self.assertRaises(TypeError):
            swimmer.rollout(dq.Sinusoid(1), 1, progress=7)

    def test_raises(self):
        swimmer = scene.swimmer()

        def fail(*_):
            raise KeyError("mine")

        for call in (lambda: swimmer.rollout(dq.Sinusoid(1), 3, progress=fail),
                     lambda: swimmer.set_weights([1, 0], progress=fail),
                     lambda: swimmer.rollout(dq.CallbackController(fail, n_signals=1), 3),
                     lambda: scene.space().close() or dq.ShapeSpace().build(progress=fail)):
            try:
                call()
            except KeyError as error:
                self.assertEqual(error.args, ("mine",))
            except dq.StateError:
                pass  # an empty space is refused before it reports anything
            else:
                self.fail("nothing was raised")
        swimmer.set_current(fail)
        with self.assertRaises(KeyError):
            swimmer.step([0.0])
        swimmer.set_current(None)
        swimmer.step([0.0])  # nothing is left over from the failures

    def test_interrupt(self):
        def interrupt(_done, _total):
            raise KeyboardInterrupt

        with self.assertRaises(KeyboardInterrupt):
            scene.swimmer().rollout(dq.Sinusoid(1), 3, progress=interrupt)

    def test_real_ctrl_c(self):
        import signal
        swimmer = scene.swimmer()
        timer = threading.Timer(0.3, lambda: signal.raise_signal(signal.SIGINT))
        timer.start()
        try:
            with self.assertRaises(KeyboardInterrupt):
                swimmer.rollout(dq.Sinusoid(1), 10**6)
        finally:
            timer.cancel()
        self.assertGreater(swimmer.info().steps, 0)

    def test_controller_and_its_pullback(self):
        def evaluate(step, time, sensors, theta):
            return np.tanh([theta[0] * np.sin(12.0 * time) + theta[1] * sensors[3]])

        def pullback(step, time, sensors, theta, bar):
            z = theta[0] * np.sin(12.0 * time) + theta[1] * sensors[3]
            slope = bar[0] / np.cosh(z) ** 2
            by_sensors = np.zeros(10)
            by_sensors[3] = slope * theta[1]
            return [slope * np.sin(12.0 * time), slope * sensors[3]], by_sensors

        swimmer = scene.swimmer()
        controller = dq.CallbackController(evaluate, n_signals=1, n_sensors=10, theta=[0.7, 0.4], pullback=pullback)
        for wrt in (dq.Wrt.CONTROL, dq.Wrt.WEIGHTS):
            report = dq.check_gradient(swimmer, TRAVEL, controller=controller, wrt=wrt, n_steps=5)
            self.assertLess(report.relative_error, 1e-6)
            self.assertAlmostEqual(report.taylor_slope, 2.0, delta=0.1)
        tape = dq.Tape(swimmer)
        swimmer.rollout(controller, 5, tape)
        del controller
        gc.collect()  # the tape keeps what it calls
        gradient, = tape.gradient(TRAVEL, dq.Wrt.CONTROL)
        self.assertEqual(gradient.shape, (2,))
        blind = dq.CallbackController(evaluate, n_signals=1, n_sensors=10, theta=[0.7, 0.4])
        tape.clear()
        swimmer.rollout(blind, 2, tape)
        with self.assertRaises(dq.StateError):
            dq.Adjoint(tape)

    def test_wrong_shapes(self):
        swimmer = scene.swimmer()
        with self.assertRaisesRegex(ValueError, r"evaluate: expected an actuation of shape \[1\], got \[2\]"):
            swimmer.rollout(dq.CallbackController(lambda *_: [0, 0], n_signals=1), 1)
        with self.assertRaisesRegex(dq.ArgumentError, r"\[-1, 1\]"):
            swimmer.rollout(dq.CallbackController(lambda *_: [3.0], n_signals=1), 1)
        tape = dq.Tape(swimmer)
        swimmer.rollout(dq.CallbackController(lambda *_: [0.5], n_signals=1, theta=[1.0], pullback=lambda *_: 7), 2,
                        tape)
        with self.assertRaisesRegex(ValueError, "pullback: expected"):
            tape.gradient(TRAVEL, dq.Wrt.CONTROL)

    def test_current_and_its_pullback(self):
        swimmer, seen = scene.swimmer(), []
        swimmer.set_current(lambda time: [0.1 * time, 0.02], lambda time, bar: seen.append((time, bar)))
        tape = dq.Tape(swimmer)
        swimmer.rollout(dq.Sinusoid(1), 3, tape)
        np.testing.assert_allclose(tape.current(2), [0.2 / 30, 0.02])
        swimmer.set_current(None)
        gc.collect()
        gradient, = tape.gradient(TRAVEL, dq.Wrt.CURRENT)
        np.testing.assert_array_equal([bar for _, bar in seen[::-1]], gradient)
        swimmer.set_current_table([0.0, 1.0, 2.0], np.zeros((3, 2)))
        tape.clear()
        swimmer.set_state()
        swimmer.rollout(dq.Sinusoid(1), 2, tape)
        self.assertEqual(tape.gradient(TRAVEL, dq.Wrt.CURRENT_TABLE)[0].shape, (3, 2))

    def test_log(self):
        messages = []
        dq.set_log_handler(lambda level, message: messages.append((level, message)), dq.LogLevel.DEBUG)
        try:
            scene.swimmer().step([0.0])
        finally:
            dq.set_log_handler(None)
        self.assertTrue({dq.LogLevel.INFO, dq.LogLevel.DEBUG} <= {level for level, _ in messages})

    def test_cancel_token(self):
        token = dq.CancelToken()
        swimmer = scene.swimmer(cancel=token)
        timer = threading.Timer(0.2, token.set)
        timer.start()
        with self.assertRaises(dq.CancelledError):
            swimmer.rollout(dq.Sinusoid(1), 10**6)
        token.reset()
        swimmer.step([0.0])
        token.close()
        swimmer.step([0.0])


class Threads(unittest.TestCase):
    def test_one_object_from_many_threads(self):
        swimmer, failures = scene.swimmer(), []

        def work():
            try:
                for _ in range(20):
                    swimmer.step([0.5])
                    swimmer.state()
            except BaseException as error:  # pylint: disable=broad-except
                failures.append(error)

        threads = [threading.Thread(target=work) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(failures, [])
        self.assertEqual(swimmer.info().steps, 80)

    def test_exceptions_belong_to_their_thread(self):
        space, found = scene.space(), {}

        def work(name):
            def fail(_done, _total):
                raise KeyError(name)
            simulator = dq.Simulator(space)
            simulator.set_weights([0.5, 0.5])
            for _ in range(5):
                try:
                    simulator.rollout(dq.Sinusoid(1), 2, progress=fail)
                except KeyError as error:
                    found.setdefault(name, set()).add(error.args[0])

        threads = [threading.Thread(target=work, args=(name,)) for name in "abc"]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(found, {name: {name} for name in "abc"})


class Everything(unittest.TestCase):
    """Each method once, with what it promises."""

    def test_space(self):
        space = scene.space()
        self.assertEqual((space.names, space.shape), (["slim", "stout"], (20, 8, 1)))
        density = space.density([0.3, 0.7])
        self.assertAlmostEqual(float(density.max()), 1.0, delta=0.05)
        bar = np.random.default_rng(1).standard_normal(space.shape)
        gradient, h = space.pullback([0.3, 0.7], bar), 1e-5
        slope = np.sum(bar * (space.density([0.3 + h, 0.7 - h]) - space.density([0.3 - h, 0.7 + h]))) / (2 * h)
        self.assertAlmostEqual((gradient[0] - gradient[1]) / slope, 1.0, delta=1e-6)
        self.assertEqual(space.signal(0).kind, dq.Actuator.CAUDAL)
        self.assertEqual(space.base(0).shape, space.shape)
        self.assertEqual(space.actuator(0, 0).kind, dq.Actuator.CAUDAL)
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "space.dqa")
            space.save(path)
            np.testing.assert_array_equal(dq.ShapeSpace.load(path).density([0.3, 0.7]), density)

    def test_bases(self):
        flat = dq.ShapeSpace(dims=2, cells_x=20, cells_y=8, cell_size=0.05)
        pixels = np.zeros((16, 40))
        pixels[6:10, 4:36] = 1.0
        self.assertEqual(flat.add_image(pixels, "bar"), 0)
        cells = np.zeros((20, 8, 1))
        cells[3:17, 3:5] = 1.0
        self.assertEqual(flat.add_density(cells, "block"), 1)
        for base in (0, 1):
            flat.add_actuator(base, dq.ActuatorOptions(mean=(-0.2, 0.0, 0.0), variance=(0.01, 0.002, 0.002)))
        self.assertEqual(flat.build().actuator(1, 0).mean, (-0.2, 0.0, 0.0))

    def test_simulator(self):
        swimmer = scene.swimmer()
        info = swimmer.info()
        swimmer.step([0.5])
        self.assertEqual(swimmer.sensors().shape, (5, 2))
        self.assertEqual(swimmer.forces().shape, (4, 2))
        surface = swimmer.surface()
        self.assertEqual((surface.vertices.shape[1], surface.elements.shape[1]), (2, 2))
        mesh = swimmer.mesh()
        self.assertEqual((len(mesh.box_index), mesh.cell_nodes.max()), (info.n_active_cells, info.n_nodes - 1))
        muscles = swimmer.muscles()
        self.assertEqual(set(muscles.signs), {-1, 1})
        self.assertEqual(swimmer.actuator(0).share, 1.0)
        index = swimmer.node_box_index()
        swimmer.set_fixed_nodes(index[:3])
        swimmer.step([0.5])
        q, _ = swimmer.state()
        swimmer.set_state()
        np.testing.assert_array_equal(q[:3], swimmer.state()[0][:3])
        swimmer.set_fixed_nodes([])
        swimmer.set_material(np.full(info.dims and 160, 3e5), None)
        with self.assertRaisesRegex(dq.ArgumentError, r"young_modulus: expected shape \[160\]"):
            swimmer.set_material([1.0])
        threshold, estimate = swimmer.suggest_threshold([0.5, 0.5], 0.1)
        self.assertTrue(0.0 <= threshold < 0.5 and estimate <= 0.1)

    def test_tape(self):
        swimmer = scene.swimmer()
        tape = dq.Tape(swimmer)
        with self.assertRaises(dq.StateError):
            tape.state(0)
        swimmer.rollout(dq.Sinusoid(1), 4, tape)
        np.testing.assert_array_equal(tape.state(4)[0], swimmer.state()[0])
        np.testing.assert_array_equal(tape.surface(4), swimmer.surface().vertices)
        self.assertEqual((tape.n_steps, tape.statistics().steps, tape.actuation(1).shape), (4, 4, (1,)))
        loss, terms = tape.objective([TRAVEL, dq.ObjectiveTerm(dq.Objective.EFFORT, weight=0.5)])
        self.assertAlmostEqual(loss, terms[0] + 0.5 * terms[1], delta=1e-15)
        path = dq.ObjectiveTerm(dq.Objective.PATH, path=[[0.0, 0.0, 0.0], [1.0, 0.5, 0.0]])
        self.assertGreater(tape.objective(path)[0], 0.0)
        shapes = {dq.Wrt.WEIGHTS: (2,), dq.Wrt.CONTROL: (3,), dq.Wrt.ACTUATION: (4, 1), dq.Wrt.WATER: (11,),
                  dq.Wrt.CURRENT: (4, 2), dq.Wrt.YOUNGS_MODULUS: (160,), dq.Wrt.MATERIAL: (4,), dq.Wrt.LAME: (2,)}
        for gradient, shape in zip(tape.gradient(TRAVEL, *shapes), shapes.values()):
            self.assertEqual(gradient.shape, shape)
            self.assertTrue(np.all(np.isfinite(gradient)))
        with dq.Adjoint(tape) as adjoint:
            bar = np.ones(tape._nodes())
            adjoint.seed(2, dq.Seed.POSITION, bar)
            adjoint.backward(to_step=2)
            with self.assertRaises(dq.StateError):
                adjoint.seed(3, dq.Seed.POSITION, bar)
            with self.assertRaises(dq.ArgumentError):
                adjoint.gradient(99)
        other = scene.swimmer()
        with self.assertRaisesRegex(dq.ArgumentError, "another simulator"):
            other.rollout(dq.Perceptron(n_signals=1, dims=2, hidden=(4,)), 2, tape)
        self.assertEqual(tape.gradient(TRAVEL, dq.Wrt.CONTROL)[0].shape, (3,))  # what was refused has left no trace
        swimmer.set_weights([1, 0])
        with self.assertRaisesRegex(dq.StateError, "another design"):
            tape.surface(1)

    def test_callbacks_do_not_change_the_simulator(self):
        swimmer = scene.swimmer()

        def meddle(_done, _total):
            self.assertEqual(swimmer.info().n_signals, 1)
            swimmer.set_weights([1, 0])

        with self.assertRaisesRegex(dq.StateError, "callback"):
            swimmer.rollout(dq.Sinusoid(1), 2, progress=meddle)
        swimmer.set_weights([1, 0])

    def test_controllers(self):
        sine = dq.Sinusoid(2)
        sine.parameters = [1.0, 2.0, np.pi / 2, 0.5, 2.0, np.pi / 2]
        np.testing.assert_allclose(sine.evaluate(0), [1.0, 0.5])
        network = dq.Perceptron(n_signals=2, dims=2, hidden=(4,), seed=3)
        self.assertEqual(network.info().n_parameters, (10 + 20 + 1) * 4 + (4 + 1) * 2)
        self.assertEqual(network.evaluate(1, np.zeros(10)).shape, (2,))
        with self.assertRaisesRegex(dq.ArgumentError, "at most 5 layers"):
            dq.Perceptron(hidden=[1] * 6)
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "network.dqa")
            network.save(path)
            np.testing.assert_array_equal(dq.Controller.load(path).parameters, network.parameters)
        with self.assertRaises(dq.UnsupportedError):
            dq.CallbackController(lambda *_: [0.0], n_signals=1).save("nowhere")

    def test_search(self):
        target = np.array([0.3, -2.0, 40.0])
        search = dq.CmaEs([0.0, 0.0, 0.0], scales=[1.0, 1.0, 20.0], seed=3)
        with self.assertRaises(dq.StateError):
            search.best()
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "search.dqa")
            for generation in range(90):
                points = search.ask()
                np.testing.assert_array_equal(points, search.ask())
                search.tell(np.sum(((points - target) / [1, 1, 20])**2, axis=1))
                if generation == 30:
                    search.save(path)
                    search = dq.CmaEs.load(path)
        x, value = search.best()
        np.testing.assert_allclose(x, target, rtol=1e-4)
        self.assertLess(value, 1e-8)
        np.testing.assert_allclose(search.mean, target, rtol=1e-4)
        self.assertEqual((search.info().generation, search.info().n), (90, 3))
        search.ask()
        with self.assertRaisesRegex(dq.ArgumentError, "values"):
            search.tell([1.0])
        with self.assertRaisesRegex(dq.ArgumentError, "scales: expected shape"):
            dq.CmaEs([0.0], scales=[1.0, 2.0])

    def test_version(self):
        with open(os.path.join(os.environ["DQA_ROOT"], "capi", "diffaqua.h"), encoding="utf-8") as file:
            numbers = re.findall(r"#define DQA_VERSION_(?:MAJOR|MINOR|PATCH) +(\d+)", file.read())
        self.assertEqual(dq.__version__, ".".join(numbers))
        self.assertTrue(all(re.fullmatch(r"\w+", name) for name in dq.features()))


if __name__ == "__main__":
    unittest.main(verbosity=1)
