# SPDX-License-Identifier: MIT
"""A progress bar for long calls."""
from __future__ import annotations

from typing import Any


class ProgressBar:
    """A tqdm bar as the `progress` of a call: simulator.rollout(..., progress=ProgressBar("swims")). One bar may serve
    many calls after each other; arguments are tqdm's."""

    def __init__(self, description: str = "", **settings: Any) -> None:
        from tqdm.auto import tqdm
        self._bar = tqdm(desc=description, **settings)

    def __call__(self, done: int, total: int) -> None:
        if self._bar.total != total or done < self._bar.n:
            self._bar.reset(total)
        self._bar.update(done - self._bar.n)

    def close(self) -> None:
        """Leaves the bar as it stands."""
        self._bar.close()

    def __enter__(self) -> ProgressBar:
        return self

    def __exit__(self, *unused: object) -> None:
        self.close()
