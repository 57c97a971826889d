# SPDX-License-Identifier: MIT
"""mypy --strict finds nothing in the package."""
import os
import subprocess
import sys

package = os.path.join(os.environ["DQA_ROOT"], "bindings", "python")
sys.exit(subprocess.run([sys.executable, "-m", "mypy", "--cache-dir",
                         os.path.join(os.environ["DQA_PYTHON_FOLDER"], "mypy")], cwd=package, check=False).returncode)
