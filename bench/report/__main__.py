"""``python -m bench.report``: all tables and diagrams of README and docs/, from one full run."""

import json

from . import (
    dae,
    delays,
    figures,
    gradients,
    hybrid,
    stiff,
    switches,
    table,
    tolerance,
    which_method,
)
from .table import RESULTS

PARTS = {
    "stiff": stiff,
    "dae": dae,
    "delays": delays,
    "gradients": gradients,
    "hybrid": hybrid,
    "switches": switches,
    "tolerance": tolerance,
    "which_method": which_method,
}


def parts(record, folder):
    """Write the groups of a full run that have files of their own; their names."""
    found = [name for name in PARTS if record.get(name)]
    for name in found:
        own = record.get("replaced", {}).get(name, record)
        part = {k: own[k] for k in ("date", "machine")} | {"quick": record["quick"]}
        part |= {k: {name: record[k][name]} for k in ("load", "seconds")}
        path = folder / f"{name}.json"
        path.write_text(json.dumps(part | {name: record[name]}, indent=1) + "\n")
    return found


def main():
    """Write them all."""
    record = json.loads(RESULTS.read_text())
    for name in parts(record, RESULTS.parent):
        PARTS[name].main()
    table.main()
    figures.draw_all(record["work_precision"], RESULTS.parent)


if __name__ == "__main__":
    main()
