"""What a run goes by: the copy of the user's cell, and what its arms do meanwhile. Says in one sentence why that cannot be."""
import json
import subprocess

import yaml  # Debian package python3-yaml

import cell_copy
import cell_document
from bad_input import BadInput
from limits import Limits
from poses import two_poses


class Setting:
    def __init__(self, options):
        try:
            self.document = cell_document.read(options.cell.read_text())
        except yaml.YAMLError as error:
            raise BadInput(f"{options.cell}: {' '.join(str(error).split())}") from error
        cell_copy.copy_of(self.document, options.cell.resolve().parent)
        self.why_spread = cell_copy.why_spread(self.document)
        if self.why_spread:
            cell_copy.spread(self.document)
        if options.no_standbys:
            cell_copy.remove_standbys(self.document)
        elif not cell_copy.has_standbys(self.document):
            cell_copy.put_standbys_in_a_ring(self.document)
        self.limits = Limits.of(self.document)
        self.require_services(options.of)

    def require_services(self, beginnings):
        names = cell_copy.services(self.document)
        for beginning in beginnings:
            if not any(name.startswith(beginning) for name in names):
                raise BadInput(f"--of = '{beginning}' must be how a service's name begins: {', '.join(names)}")

    def poses(self, plan):
        """Between which all arms go; `plan`: what `hecaton check` told of them."""
        chosen = two_poses(plan["arms"], (self.document.get("tasks") or {}).get("route", ()))
        if not chosen:
            raise BadInput(f"cell {plan['cell']}: two named poses that every arm has, apart from each other, are needed for "
                           "the arms to go to and fro")
        return chosen

    def told(self):
        """How the copy differs from the cell file, where that must be known."""
        hosts = ", ".join(f"{name} {address}" for name, address in self.document["hosts"].items())
        spread = f"the cell is spread, for {self.why_spread}: {hosts}\n" if self.why_spread else ""
        return spread + f"silent is a process after {self.limits.silence:g} s, a host after {self.limits.lease:g} s"


def check(hecaton, file):
    """What `hecaton check` tells of a cell file that is good."""
    if not hecaton.exists():
        raise BadInput(f"{hecaton} is missing: ./run build makes it")
    checked = subprocess.run([hecaton, "check", file, "-o", "json"], capture_output=True, text=True)
    if checked.returncode not in (0, 1):
        raise BadInput(checked.stderr.strip().removeprefix("hecaton: "))
    plan = json.loads(checked.stdout)
    if "arms" not in plan:
        raise BadInput(f"{file} must be a cell file, and describes a robot")
    if checked.returncode == 1:
        raise BadInput(next(f["sentence"] for f in plan["findings"] if f["severity"] == "error"))
    return plan
