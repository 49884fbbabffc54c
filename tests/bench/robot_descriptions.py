#!/usr/bin/env python3
"""Checks many public robot descriptions: what `hecaton check FILE` says of each, beside what this script expects of it.

usage: robot_descriptions.py BIN FOLDER... [--maker-depth N] [--time-limit SECONDS] [--csv FILE]
       robot_descriptions.py --self-test BIN

BIN is the folder of Hecaton's programs. Each FOLDER has repositories. A file *.urdf or *.xacro below it counts if it has a <robot>
with a name. Xacro files that only define macros do not count.
  --maker-depth  the maker of a file is this part of its path below FOLDER (0)
  --csv          also writes the counts of each maker

The expectation of every file is written down before the first run. A URDF is usable if it is XML, each joint names links of the file,
a joint moves, and each mesh is found. Of options and of xacro files it says nothing. Outcomes:
  accepted     as it is
  options      with options that the messages name: --tool, --default-velocity, --allow-bare-links, --package
  refused      with one sentence
  crashed      ended by a signal, with another exit code, without a sentence, or not within the limit
Exit code 1: a file crashed, or a usable file is refused. Those are listed."""
import argparse
import collections
import csv
import pathlib
import re
import subprocess
import sys
import tempfile
import urllib.parse
import xml.etree.ElementTree

REFUSALS = (1, 2, 3)  # exit codes of a refusal
MOST_OPTIONS = 8  # a file that still needs one is refused
MOVING = ("revolute", "continuous", "prismatic")


def find_mesh(name, file, folder):
    """True if the file of a mesh exists: beside the URDF, or below a folder of the package's name."""
    name = urllib.parse.unquote(name)
    if name.startswith("package://"):
        package, _, rest = name[len("package://"):].partition("/")
        return any((place / rest).is_file() for place in [*folder.rglob(package), *folder.glob(package)]) or any(
            (parent / rest).is_file() for parent in file.parents)
    name = name.removeprefix("file://")
    return (file.parent / name).is_file()


def expectation(file, folder):
    """usable, faulty with the reason, or unknown."""
    if file.suffix == ".xacro":
        return "unknown", "xacro"
    try:
        robot = xml.etree.ElementTree.parse(file).getroot()
    except (xml.etree.ElementTree.ParseError, UnicodeDecodeError) as error:
        return "faulty", f"no XML: {error}"
    if re.search(r"\$\{|\$\(", file.read_text(errors="replace")):
        return "unknown", "xacro text"
    links = {link.get("name") for link in robot.findall("link")}
    joints = robot.findall("joint")
    for joint in joints:
        for part in ("parent", "child"):
            element = joint.find(part)
            if element is None or element.get("link") not in links:
                return "faulty", f"joint {joint.get('name')} has no {part} in the file"
    if not any(joint.get("type") in MOVING for joint in joints):
        return "faulty", "no joint moves"
    for mesh in robot.iterfind("link/collision/geometry/mesh"):
        if not find_mesh(mesh.get("filename", ""), file, folder):
            return "faulty", f"mesh {mesh.get('filename')} is missing"
    return "usable", ""


def is_robot(file):
    text = file.read_text(errors="replace")
    root = re.search(r"<robot\b[^>]*>", text)
    if not root or "name=" not in root[0]:
        return False
    if file.suffix == ".urdf":
        return True
    # A file that only defines macros has no link and calls nothing.
    outside = re.sub(r"<xacro:macro\b.*?</xacro:macro>", "", text, flags=re.S)
    return bool(re.search(r"<link\b|<xacro:(?!include|property|arg|macro|if|unless)\w+", outside))


def files_of(folder):
    found = set()
    for pattern in ("*.urdf", "*.xacro"):
        found |= {file for file in folder.rglob(pattern) if file.is_file() and is_robot(file)}
    return sorted(found)


def next_option(message, folder):
    """The option that the message names, with a value; None: it names none that this script can give."""
    package = re.search(r"\(--package ([^= ]+)=DIR\)", message)
    if package:
        places = [place for place in folder.rglob(package[1]) if place.is_dir()]
        return ["--package", f"{package[1]}={places[0]}"] if places else None
    tool = re.search(r"--tool ([^\s,;)]+)", message)
    if tool and tool[1] != "LINK":
        return ["--tool", tool[1].strip("'")]
    if "--tool LINK" in message:
        links = re.findall(r"'([^']+)'", message)
        return ["--tool", links[-1]] if links else None
    if "--default-velocity" in message:
        return ["--default-velocity", "1"]
    if "--allow-bare-links" in message:
        return ["--allow-bare-links"]
    return None


def check(programs, file, folder, time_limit):
    """Outcome, its sentence, and the options."""
    options = []
    while True:
        try:
            done = subprocess.run([programs / "hecaton", "check", file, *options], capture_output=True, timeout=time_limit)
        except subprocess.TimeoutExpired:
            return "crashed", f"not done within {time_limit:.0f} s", options
        message = done.stderr.decode(errors="replace").strip()
        if done.returncode == 0:
            return ("options" if options else "accepted"), "", options
        if done.returncode not in REFUSALS or not message:
            return "crashed", f"exit code {done.returncode}: {message}", options
        option = next_option(message, folder)
        if option is None or (option[0] in options and option[0] != "--package") or len(options) > MOST_OPTIONS:
            return "refused", message, options
        options += option


def sweep(programs, folders, depth, time_limit):
    """Counts of each maker, and the files that crashed or are refused wrongly."""
    counts = collections.defaultdict(collections.Counter)
    wrong = []
    for folder in folders:
        files = files_of(folder)
        expected = {file: expectation(file, folder) for file in files}  # before the first run
        for file in files:
            outcome, sentence, options = check(programs, file, folder, time_limit)
            usable = expected[file][0] == "usable"
            maker = file.relative_to(folder).parts[depth] if len(file.relative_to(folder).parts) > depth else folder.name
            counts[maker][outcome] += 1
            counts["all"][outcome] += 1
            counts["all"]["files"] += 1
            counts[maker]["files"] += 1
            if outcome == "crashed" or (usable and outcome == "refused"):
                wrong.append((file, outcome, sentence))
            print(f"{outcome:9} {file.relative_to(folder)} (expected {' '.join(expected[file])}) {' '.join(options)} {sentence}".rstrip(),
                  flush=True)
    return counts, wrong


OUTCOMES = ("files", "accepted", "options", "refused", "crashed")


def self_test(programs):
    link = "<link name='{}'><collision><geometry><sphere radius='0.05'/></geometry></collision></link>"
    joint = "<joint name='j' type='revolute'><parent link='a'/><child link='b'/><axis xyz='0 0 1'/>{}</joint>"
    limit = "<limit lower='-1' upper='1' velocity='1' effort='1'/>"
    ball = link.format("a") + link.format("b")
    mesh = "<link name='a'/><link name='b'><collision><geometry><mesh filename='{}'/></geometry></collision></link>"
    files = {
        "fine.urdf": (ball + joint.format(limit), "usable", "accepted"),
        "slow.urdf": (ball + joint.format("<limit lower='-1' upper='1' effort='1'/>"), "usable", "options"),
        "bare.urdf": ("<link name='a'/><link name='b'/>" + joint.format(limit), "usable", "options"),
        "no_link.urdf": (link.format("a") + joint.format(limit), "faulty", "refused"),
        "still.urdf": (ball + joint.format("").replace("revolute", "fixed"), "faulty", "refused"),
        "no_mesh.urdf": (mesh.format("none.stl") + joint.format(limit), "faulty", "refused"),
    }
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for file, (inside, _, _) in files.items():
            (folder / file).write_text(f"<robot name='r'>{inside}</robot>")
        (folder / "broken.urdf").write_text("<robot name='r'><link")
        (folder / "macros.xacro").write_text("<robot name='r'><xacro:macro name='m'><link name='a'/></xacro:macro></robot>")
        assert [file.name for file in files_of(folder)] == sorted([*files, "broken.urdf"]), files_of(folder)
        assert expectation(folder / "broken.urdf", folder)[0] == "faulty"
        for file, (_, expected, outcome) in files.items():
            assert expectation(folder / file, folder)[0] == expected, file
            found = check(programs, folder / file, folder, 100)
            assert found[0] == outcome, (file, found)
        counts, wrong = sweep(programs, [folder], 0, 100)
        assert not wrong and counts["all"]["files"] == 7 and counts["all"]["crashed"] == 0, (counts, wrong)
        # A program that dies counts as crashed, and so does a usable file that is refused.
        (folder / "bin").mkdir()
        for script, outcome in (("kill -SEGV $$", "crashed"), ("echo 'hecaton: no' >&2; exit 3", "refused")):
            program = folder / "bin/hecaton"
            program.write_text(f"#!/bin/sh\n{script}\n")
            program.chmod(0o755)
            counts, wrong = sweep(folder / "bin", [folder], 0, 100)
            assert counts["all"][outcome] == 7 and ("fine.urdf" in {file.name for file, _, _ in wrong}), (counts, wrong)
    print("all as expected")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("programs", type=pathlib.Path, metavar="BIN")
    parser.add_argument("folders", type=pathlib.Path, nargs="*", metavar="FOLDER")
    parser.add_argument("--maker-depth", type=int, default=0)
    parser.add_argument("--time-limit", type=float, default=300.0)
    parser.add_argument("--csv", type=pathlib.Path)
    parser.add_argument("--self-test", action="store_true")
    options = parser.parse_args()
    if options.self_test:
        return self_test(options.programs.resolve())
    counts, wrong = sweep(options.programs.resolve(), [folder.resolve() for folder in options.folders], options.maker_depth,
                          options.time_limit)
    rows = [[maker, *(counts[maker][outcome] for outcome in OUTCOMES)]
            for maker in sorted(counts, key=lambda maker: (maker == "all", -counts[maker]["files"], maker))]
    for row in [["maker", *OUTCOMES], *rows]:
        print(f"{row[0]:28}" + "".join(f"{cell:>10}" for cell in row[1:]))
    if options.csv:
        with options.csv.open("w", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows([["maker", *OUTCOMES], *rows])
    for file, outcome, sentence in wrong:
        print(f"wrong: {outcome} {file}: {sentence}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
