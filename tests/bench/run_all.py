"""All benchmarks, one after the other: `make bench`. Each bench_*.py has a `main(argv)` that returns its rows.

`make bench ARGS="NAME … -- OPTION …"` runs only some, with options of theirs; bench.json keeps what others found.
"""

from __future__ import annotations

import json
import os
import platform
import runpy
import sys
from importlib.metadata import version
from pathlib import Path
from time import perf_counter
from typing import Any

HERE = Path(__file__).parent
RESULT = HERE.parents[1] / "bench.json"


def main(argv: list[str]) -> None:
    """Run the benchmarks of these names (`backends`), by default all, and write bench.json."""
    cut = argv.index("--") if "--" in argv else len(argv)
    names, options = argv[:cut], argv[cut + 1 :]
    sys.path.insert(0, str(HERE.parent))
    files = {path.stem.removeprefix("bench_"): path for path in sorted(HERE.glob("bench_*.py"))}
    if unknown := set(names) - files.keys():
        sys.exit(f"no benchmark {', '.join(sorted(unknown))}; there are {', '.join(files)}")
    results: dict[str, Any] = json.loads(RESULT.read_text(encoding="utf-8")) if names and RESULT.exists() else {}
    results["machine"] = machine()
    for name in names or files:
        print(f"== {name}", flush=True)
        start = perf_counter()
        rows = runpy.run_path(str(files[name]))["main"](options)
        results[name] = {"seconds": round(perf_counter() - start, 2), "rows": rows}
        RESULT.write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")
    print(f"{RESULT.name} written")


def machine() -> dict[str, Any]:
    """What the figures were measured on and with."""
    packages = ("splinescope", "numpy", "numba", "scipy", "gtsam", "viser")
    return {
        "processor": platform.machine(),
        "cores": os.cpu_count(),
        "python": platform.python_version(),
        "versions": {name: version(name) for name in packages},
    }


if __name__ == "__main__":
    main(sys.argv[1:])
