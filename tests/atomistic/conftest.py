"""Validations without processes of their own."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests.tasks import tasks_here


@pytest.fixture(autouse=True, scope="session")
def in_this_process() -> Iterator[None]:
    """Paths of a validation with one worker are compared here; those of several workers have their processes."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("atomistic.front.validation.run_tasks", tasks_here)
        yield
