"""`python -m skillfold`: the command line."""

from skillfold.cli import main

raise SystemExit(main())
