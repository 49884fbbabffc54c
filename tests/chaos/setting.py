"""The setting of a run: the copy of the cell file, and the poses of the arms. Errors are one sentence."""
import json
import os
import pathlib
import subprocess
import tempfile

import yaml  # Debian package python3-yaml

import cell_copy
import cell_document
import namespaces
from bad_input import BadInput
from injections import FEWEST_TO_SPLIT
from limits import Limits
from poses import two_poses


PROGRAMS = ("hecaton", *(f"hecaton-{name}" for name in ("agent", "planner", "arm-driver", "world", "supervisor")),
            "libhost_clock.so")
COPY = "chaos-cell.yaml"  # in the folder of the logs
KEYSTORE = "keys"  # the same


class Setting:
    def __init__(self, options):
        try:
            self.document = cell_document.read(options.cell.read_bytes())
        except yaml.YAMLError as error:
            raise BadInput(f"{options.cell}: {' '.join(str(error).split())}") from error
        cell_copy.copy_of(self.document, folder_of(options.cell), options.timeout_scale)
        self.why_spread = cell_copy.why_spread(self.document)
        if self.why_spread:
            cell_copy.spread(self.document)
        if options.no_standbys:
            cell_copy.remove_standbys(self.document)
        elif not cell_copy.has_standbys(self.document):
            cell_copy.put_standbys_in_a_ring(self.document)
        self.limits = Limits.of(self.document)
        self.require_services(options.of)
        self.require_hosts(options.only)

    def require_services(self, beginnings):
        names = cell_copy.services(self.document)
        for beginning in beginnings:
            if not any(name.startswith(beginning) for name in names):
                raise BadInput(f"--of = '{beginning}' must be the beginning of the name of a service: {', '.join(names)}")

    def require_hosts(self, kinds):
        if set(kinds) == {"split"} and len(self.document["hosts"]) < FEWEST_TO_SPLIT:
            raise BadInput(f"--only = 'split' needs a cell of at least {FEWEST_TO_SPLIT} hosts; this cell has "
                           f"{len(self.document['hosts'])}; use 'cut'")

    def poses(self, plan):
        """The two poses between which all arms move. `plan`: output of `hecaton check`."""
        chosen = two_poses(plan["arms"], (self.document.get("tasks") or {}).get("pose_sequence", ()))
        if not chosen:
            raise BadInput(f"cell {plan['cell']}: two named poses that every arm has, apart from each other, are needed for "
                           "the arms to go back and forth")
        return chosen

    def require_files(self, options):
        """Output files must be writable and must not overwrite input files."""
        written = [("--report", options.report)] if options.report else []
        if options.logs:
            make_folder("--logs", options.logs)
            if options.keys and (options.logs / KEYSTORE).exists():
                raise BadInput(f"--logs = '{options.logs}' must not have a keystore ({KEYSTORE}) yet, because of --keys")
            logs = [("--logs", options.logs / name) for name in (COPY, *(f"{host}.log" for host in self.document["hosts"]))]
            for _, log in logs:
                if options.report and is_same(log, options.report):
                    raise BadInput(f"--report = '{options.report}' must not be a file in --logs")
            written += logs
        for option, file in written:
            if is_same(file, options.cell):
                raise BadInput(f"{option} = '{getattr(options, option[2:])}' must not overwrite the cell file {options.cell}")

    def lock(self, hecaton, folder):
        """Gives the copy keys: a new keystore in `folder`, with the identities of all hosts."""
        keystore = folder / KEYSTORE
        for words in ["create", keystore], *(["add", keystore, host] for host in self.document["hosts"]):
            made = subprocess.run([hecaton, "keystore", *words], capture_output=True, encoding="utf-8", errors="replace")
            if made.returncode:
                raise BadInput(made.stderr.strip().removeprefix("hecaton: "))
        cell_copy.section(self.document, "security")["keystore"] = cell_document.Quoted(keystore)

    def text(self):
        """The important differences of the copy from the cell file."""
        hosts = ", ".join(f"{name} {address}" for name, address in self.document["hosts"].items())
        spread = f"the cell is spread over hosts, because {self.why_spread}: {hosts}\n" if self.why_spread else ""
        keys = f"the cell has keys: {self.document['security']['keystore']}\n" if self.document.get("security") else ""
        return spread + keys + f"time-outs: process {self.limits.silence:g} s, host {self.limits.lease:g} s"


def folder_of(file):
    """Paths in a cell file are relative to its name, which may be a link."""
    return file.parent.absolute()


def is_same(one, other):
    try:
        return os.path.samefile(one, other)
    except OSError:  # one does not exist yet
        return one.resolve() == other.resolve()


def make_folder(option, folder):
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BadInput(f"{option} = '{folder}' must be a folder: {error.strerror}") from error
    if not os.access(folder, os.W_OK | os.X_OK):
        raise BadInput(f"{option} = '{folder}' must be a folder that can be written to")


def require_programs(folder):
    """Requires all programs of the hosts."""
    for name in PROGRAMS:
        if not (folder / name).exists():
            raise BadInput(f"{folder / name} is missing; run ./run build")


def require_sight(options):
    """Requires that hosts see all files."""
    needed = [("CELL", options.cell), ("--report", options.report), ("--programs", options.programs)]
    needed.append(("--logs", options.logs) if options.logs else ("TMPDIR", pathlib.Path(tempfile.gettempdir())))
    for what, path in needed:
        if path and namespaces.Namespaces.hides(path):
            raise BadInput(f"{what} = '{path}' must not be below {namespaces.Namespaces.OWN}, which hosts replace by their own")


def check_given(hecaton, file):
    """Checks the user's cell file. Its network interface may be of another machine, because the copy names none."""
    try:
        return check(hecaton, file)
    except BadInput as refused:
        try:
            document = cell_document.read(file.read_bytes())
            del document["network"]["interface"]
            cell_copy.make_paths_absolute(document, folder_of(file))
        except (OSError, yaml.YAMLError, LookupError, TypeError, AttributeError):  # `hecaton check` reports the error
            raise refused from None
    with tempfile.TemporaryDirectory() as folder:
        copy = pathlib.Path(folder) / file.name
        copy.write_text(cell_document.write(document), encoding="utf-8")
        try:
            return check(hecaton, copy)
        except BadInput as error:
            raise BadInput(str(error).replace(str(copy), str(file))) from None


def check(hecaton, file):
    """The output of `hecaton check` for a valid cell file."""
    checked = subprocess.run([hecaton, "check", file, "-o", "json"], capture_output=True, encoding="utf-8", errors="replace")
    if checked.returncode not in (0, 1):
        raise BadInput(checked.stderr.strip().removeprefix("hecaton: "))
    plan = json.loads(checked.stdout)
    if "arms" not in plan:
        raise BadInput(f"{file} must be a cell file; it is a robot description")
    if checked.returncode == 1:
        raise BadInput(next(f["sentence"] for f in plan["findings"] if f["severity"] == "error"))
    return plan
