"""Values that are no good for most arguments, and what is asked of a function that is given one of them."""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from hypothesis import strategies as st

__all__ = ["ANYTHING", "refused_by_name"]

ANYTHING = st.one_of(
    st.none(),
    st.booleans(),
    st.text(max_size=5),
    st.complex_numbers(),
    st.floats(),
    st.integers(),
    st.just(10**400),
    st.lists(st.integers(), max_size=3),
    st.lists(st.text(max_size=3), max_size=3),
    st.sampled_from([object(), {}, {1, 2}, b"bytes", int, np.True_, np.array(0.25), np.array("text")]),
    st.tuples(st.integers(0, 3), st.integers(0, 3)).map(np.zeros),
    st.sampled_from([np.full((4, 4), np.nan), np.zeros((4, 4), dtype=complex), np.ones((4, 4)) > 0, np.arange(5.0)]),
    st.just(np.ma.masked_less(np.arange(16.0).reshape(4, 4), 3)),
)


def refused_by_name(function: Callable[..., object], good: Mapping[str, Any], name: str, value: Any) -> bool:
    """Whether a function refuses a value of one argument; that must be a ValueError or TypeError with its name.

    A file that is not there is named itself.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            warnings.filterwarnings("ignore", "Setting the shape on a NumPy array", DeprecationWarning)  # by ASE
            warnings.simplefilter("ignore", UserWarning)  # ours, of what a grid does not resolve
            function(**{**good, name: value})
            return False
    except (ValueError, TypeError) as error:
        message = str(error)
    assert re.search(rf"\b{name}\b|no such file|a folder", message), f"{name} = {value!r}: {message}"
    return True
