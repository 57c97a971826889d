# SPDX-License-Identifier: MIT
"""Shape and control by SciPy's L-BFGS-B: weights need not be normalised, only stay positive; bounds keep the rest."""
import numpy as np
from scipy.optimize import minimize

import fish

options = fish.arguments(__doc__, iterations=12)
rollout, w0, theta0 = fish.rollout(options.steps)
log = fish.Log(options.tensorboard)
# Steps of the search are of one size for all unknowns, and the loss is small: both are brought to about 1.
scale, unit = np.array([1.0, 1.0, 1.0, 15.0, 1.0]), 1e3


def value_and_gradient(y):
    loss, gradient = rollout.packed(y * scale)
    log(loss, (y * scale)[:2], (y * scale)[2:])
    return unit * loss, unit * gradient * scale


found = minimize(value_and_gradient, np.concatenate([w0, theta0]) / scale, jac=True, method="L-BFGS-B",
                 bounds=[(1e-3, 1.0), (1e-3, 1.0), (0.0, 1.0), (0.2, 2.0), (-3.0, 3.0)],
                 options={"maxiter": options.iterations, "maxfun": 2 * options.iterations})
print(found.message)
log.close()
