"""What passes of PyTorch over memory there are, counted as its operations are dispatched."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import torch
from torch.utils._python_dispatch import TorchDispatchMode
from torch.utils._pytree import tree_leaves

from continuum.model.fourier import Real
from continuum.solve.arrays.library import Torch

VIEWS = ("view", "select", "slice", "unsqueeze", "permute", "detach", "lift_fresh", "alias", "expand", "empty")
"""Beginnings of the names of operations that touch no memory."""


class Passes(TorchDispatchMode):
    """Counts in units of so many numbers in double precision."""

    def __init__(self, size: int) -> None:
        super().__init__()
        self.size, self.passes, self.launches, self.reads, self.inside = size, 0.0, 0, 0, False

    def add(self, touched: Any, factor: int = 1) -> None:
        """One operation reads or writes each of some tensors, a broadcast one as it lies in memory."""
        sizes = {
            (each.data_ptr(), each.shape): min(each.numel() * each.element_size(), each.untyped_storage().nbytes())
            for each in tree_leaves(touched)
            if isinstance(each, torch.Tensor)
        }
        self.passes += factor * sum(sizes.values()) / (8 * self.size)
        self.launches += 1

    def __torch_dispatch__(self, func: Any, types: Any, args: Any = (), kwargs: Any = None) -> Any:
        found, name = func(*args, **(kwargs or {})), func.__name__
        if self.inside or func.is_view or name.startswith(VIEWS):
            return found
        if "local_scalar" in name:
            self.reads += 1
        else:
            self.add((args, kwargs, found), 2 if "_fft" in name else 1)  # a half along each direction
        return found


class Counted(Torch):
    """PyTorch on processor cores, whose fused functions count as one pass."""

    def __init__(self) -> None:
        super().__init__("cpu")
        self._mode: Passes | None = None

    @contextmanager
    def counting(self, size: int) -> Iterator[Passes]:
        with Passes(size) as self._mode:
            yield self._mode
        self._mode = None

    def compile(self, function: Callable[..., Any]) -> Callable[..., Any]:
        def run(*given: Any, **named: Any) -> Any:
            if self._mode is None:
                return function(*given, **named)
            self._mode.inside = True
            found = function(*given, **named)
            self._mode.inside = False
            self._mode.add((given, found))
            return found

        return run

    def get(self, values: Any) -> Real:
        if self._mode is not None:
            self._mode.reads += 1
        return super().get(values)
