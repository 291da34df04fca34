"""``python -m continuum`` is the command ``continuum``."""

from continuum.cli import main

raise SystemExit(main())
