"""Compares the reference pages (docs/reference, and the index in docs/README.md) with the programs and the sources.

usage: reference_pages.py ROOT BIN [--write]     BIN: the folder of the programs; --write: renews the generated parts

| page | the source of the comparison |
|---|---|
| cli.md | commands of `hecaton man`, `hecaton-strategies man`, exit codes of `hecaton --help` and `hecaton-chaos --help`: generated |
| topics.md | services/bus/topics.hpp and idl/: generated |
| robots.md | `hecaton robots`: generated |
| ready-cells.md | the first sentence of each cell file in deploy/cells: generated |
| faults.md | idl/cause.idl: each fault kind has its section, and the other causes are a generated list |
| all documents | --help: the commands and options of `hecaton`, `hecaton-strategies` and `hecaton-chaos` in code exist |
| docs/README.md | docs/: it lists every page; the list of design notes is generated |
| cell-file.md | `hecaton check`: the ranges and the choices in the column "allowed" are those that it enforces |
"""
import argparse
import difflib
import itertools
import json
import pathlib
import re
import subprocess
import sys
import tempfile
import textwrap

GENERATED = re.compile(r"(<!-- generated: (\w+) -->\n).*?(<!-- end -->)", re.S)


def output(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


# --- cli.md


def plain(troff):
    return re.sub(r"\\f[BIR]", "", troff).replace("\\-", "-").replace("\\(aq", "'").replace("\\e", "\\")


def sections_of(man):
    """[(command line, sentence, [(argument, meaning)], remarks)] of a man page; remarks are Markdown."""
    lines = man.splitlines()
    begin = next(i for i, line in enumerate(lines) if line.startswith(".SH COMMANDS"))
    end = next((i for i, line in enumerate(lines) if line.startswith(".SH") and i > begin), len(lines))
    sections, row = [], iter(lines[begin + 1:end])
    for line in row:
        if line.startswith(".SS "):
            rows, text = [], []
            sections.append((plain(line[4:]), rows, text))
        elif line == ".TP":
            rows.append((plain(next(row)), plain(next(row)).replace("<", "\\<")))
        elif line == ".PP":
            text.append("")
        else:
            entry = line.startswith("  ")
            if text and text[-1] and entry != text[-1].startswith("- "):
                text.append("")  # a list begins or ends
            text.append(("- " if entry else "") + plain(line).strip())
    found = []
    for command, rows, text in sections:
        sentence, _, remarks = "\n".join(text).strip().partition("\n")
        found.append((command, sentence, rows, remarks.strip()))
    return found


# Sentences of remarks that authors of scripts need; options and everything else of a command are said by its --help.
FOR_SCRIPTS = re.compile(r"[Ee]xit code")


def commands(man):
    """The names of all commands, and a line for those that have exit codes of their own. --help has a sentence for each."""
    names, codes = [], {}
    for command, _, _, remarks in sections_of(man):
        prose = [*filter(FOR_SCRIPTS.search, re.split(r"(?<=\.)\s+", " ".join(remarks.split())))]
        words = command.split()
        # The page says how to get man pages and completions for all programs; the members of a group stand for it.
        if words[-1] == "man" or "completion" in command:
            continue
        name = " ".join(word for word in words[1:] if word.islower())
        if not command.endswith(" COMMAND"):
            names.append(name)
        if prose:
            codes.setdefault(re.sub("^Exit code:? ", "", " ".join(prose)), []).append(f"`{name}`")
    block = textwrap.fill(", ".join(name.replace(" ", "\xa0") for name in names), 120, break_on_hyphens=False).replace("\xa0", " ")
    return f"```\n{block}\n```\n\nExit codes of their own:\n\n" + "".join(f"- {', '.join(owners)}: {text}\n" for text, owners in codes.items())


def exit_codes(program):
    """The list of what its --help ends with: "Exit codes: 0 done; 1 …"."""
    codes = " ".join(output(program, "--help").split()).rsplit("Exit codes: ", 1)[1].rstrip(".")
    rows = [entry.split(" ", 1) for entry in re.split(r"; (?=\d+ )", codes)]
    return "".join(f"- {code}: {text}\n" for code, text in rows)


def cli_parts(binaries):
    return {
        "exit_codes": exit_codes(binaries / "hecaton"),
        "chaos_codes": exit_codes(binaries / "hecaton-chaos"),
        "commands": commands(output(binaries / "hecaton", "man")),
        "strategies": commands(output(binaries / "hecaton-strategies", "man")),
    }


# --- topics.md


def structs(root):
    """The comment above every struct of idl/ by its name, and its file."""
    found = {}
    for file in sorted((root / "idl").rglob("*.idl")):
        for match in re.finditer(r"((?:^//[^\n]*\n)*)^@\w+\n^struct (\w+) \{\n", file.read_text(), re.M):
            found[match[2]] = (" ".join(re.sub(r"^// ", "", match[1], flags=re.M).split()), file.relative_to(root))
    return found


def topic_rows(text):
    macro = text[text.index("#define HECATON_TOPICS(TOPIC)"):text.index("// clang-format on")].replace("\\\n", " ")
    macro = re.sub(r"/\*.*?\*/", "", macro)
    for match in re.finditer(r"TOPIC\((\w+), (.*?), \"(.*?)\", \"(.*?)\"(.*?)\)(?= +TOPIC|\s*$)", macro, re.S):
        name, key, writers, readers, qos = match.groups()
        yield name, "" if key == '""' else key, writers.split(), readers.split(), dict(re.findall(r"\.(\w+) = (\w+)", qos))


def key_text(key):
    return re.sub(r"sample\.(\w+)\(\)", r"\1", key).replace(' + "/" + ', "/") or "none"


def delivery(qos):
    reliable = "kept" if "transient_local" in qos else "reliable"
    words = [reliable if qos.get("reliable") == "true" else "best effort"]
    words += ["to readers of its arm"] * ("partition_per_key" in qos)
    words += [f"{name} {qos[name]}" for name in ("deadline",) if name in qos]
    return ", ".join(words)


def topics_parts(root):
    """A table, with a heading for each file of idl/."""
    known, files = structs(root), {}
    for name, key, writers, readers, qos in topic_rows((root / "services/bus/topics.hpp").read_text()):
        content, file = known[name]
        content = re.split(r"(?<=\.) (?=[A-Z])", content)[0].rstrip(".")  # the IDL file has the rest
        content = re.sub(r" \(docs/(\S+?\.md)\)", r" ([why](../\1))", content)
        files.setdefault(file, []).append(f"| `hecaton/{name}` | {content} | {key_text(key)} | {', '.join(writers)} "
                                          f"| {', '.join(readers)} | {delivery(qos)} |\n")
    head = "| topic | content | key | from | to | delivery |\n|---|---|---|---|---|---|\n"
    return {"topics": head + "".join(f"| **`{file}`** | | | | | |\n{''.join(rows)}" for file, rows in files.items())}


# --- robots.md


def robots_parts(binaries):
    """A line for each maker, by the first word of the robots' titles. `hecaton robots` says the rest."""
    makers = {}
    for robot in json.loads(output(binaries / "hecaton", "robots", "-o", "json"))["robots"]:
        makers.setdefault(robot["title"].split()[0].replace("Universal", "Universal Robots"), []).append(f"`{robot['name']}`")
    return {"robots": "".join(f"- {maker}: {', '.join(names)}\n" for maker, names in sorted(makers.items()))}


# --- ready-cells.md


def sentence_of(cell):
    """The first sentence of a cell file, without a figure or section of a paper, and without details behind a semicolon or a colon."""
    lines = itertools.takewhile(lambda line: line.startswith("#"), cell.read_text(encoding="utf-8").splitlines())
    sentence = re.match(r".+?(?<!fig)\.(?=\s+[A-Z\[]|$)", " ".join(line[1:].strip() for line in lines)).group()
    text = re.sub(r"^\[\w+\] (fig\.|sections?) [\d to]+: ", "", sentence.rstrip("."))
    text = re.split("[:;] ", text)[0]
    return (text[0].upper() + text[1:]).replace("|", "\\|")


def cells_part(root):
    """A row for each cell, with the picture that docs/figures/draw_cells.py draws."""
    folder = root / "deploy/cells"
    rows = [(cell.relative_to(folder).with_suffix(""), cell) for cell in [*sorted(folder.glob("*.yaml")), *sorted(folder.glob("named/*.yaml"))]]
    return {"cells": "| cell | as it starts | what it is |\n|---|---|---|\n" + "".join(
        f"| `{name}` | ![{name}](../figures/cells/{cell.stem}.png) | {sentence_of(cell)} |\n" for name, cell in rows)}


# --- faults.md


def cause_sections(root):
    """{section: [(kind, meaning)]} of the enumeration, in its order."""
    sections, rows = {}, None
    for line in (root / "idl/cause.idl").read_text().split("enum CauseKind {")[1].split("};")[0].splitlines():
        if heading := re.fullmatch(r"  // (\w[^,;:.]*).*", line):
            rows = sections.setdefault(heading[1], [])
        elif entry := re.fullmatch(r"  CAUSE_(\w+),? +// (.*)", line):
            if rows is not None:
                rows.append((entry[1].lower(), entry[2]))
    return sections


def causes_part(root):
    text = ""
    for section, rows in cause_sections(root).items():
        if section == "Faults":
            continue
        text += f"### {section}\n" + "".join(f"- `{kind}`: {meaning}\n" for kind, meaning in rows) + "\n"
    return {"causes": text.rstrip() + "\n"}


def fault_findings(root, page):
    """A heading in front of the kinds of a chapter counts for all of them."""
    kinds = [kind for kind, _ in cause_sections(root)["Faults"]]
    sections = {}
    for chapter in re.split(r"^## ", page, flags=re.M):
        common = chapter.split("\n### ", 1)[0]
        for kind, text in re.findall(r"^### `(\w+)`\n(.*?)(?=^###|\Z)", chapter, re.M | re.S):
            sections[kind] = common + text
    for kind in kinds:
        if kind not in sections:
            yield f"faults.md has no section for `{kind}`"
            continue
        for heading in ("**Cause.**", "**The cell**", "**You**"):
            if heading not in sections[kind]:
                yield f"faults.md: `{kind}` does not have {heading}"
    for kind in sections:
        if kind not in kinds:
            yield f"faults.md: there is no fault kind `{kind}`"


# --- docs/README.md


def index_part(root):
    """A line for each design note, with its heading."""
    notes = sorted((root / "docs/explanation").glob("0*.md"))
    headings = [(note.name, note.read_text().split("\n", 1)[0].lstrip("# ")) for note in notes]
    return {"design": "".join(f"- [{heading}](explanation/{name})\n" for name, heading in headings)}


def index_findings(root):
    index = (root / "docs/README.md").read_text()
    for page in sorted((root / "docs").rglob("*.md")):
        name = page.relative_to(root / "docs").as_posix()
        if name != "README.md" and f"({name})" not in index:
            yield f"docs/README.md does not list {name}"


# --- cell-file.md

BASE = """name: test
{root}arms:
  - name: left
    urdf: {urdf}
    poses: {{home: [0, -1.9, 2.6, 0, 0.6, 0]}}
{arm}{obstacles}"""

# Where a map of the section stands in the smallest cell file: its keys come into the place of KEYS.
PLACES = {
    "network": ("root", "network: {KEYS}"),
    "world": ("root", "world: {KEYS}"),
    "supervision": ("root", "supervision: {KEYS}"),
    "supervision.recovery": ("root", "supervision: {recovery: {KEYS}}"),
    "timing": ("root", "timing: {KEYS}"),
    "ros2": ("root", "ros2: {KEYS}"),
    "tasks": ("root", "tasks: {KEYS}"),
    "tasks.clutter": ("root", "tasks: {centre: [0, 0, 0], clutter: {KEYS}}"),
    "arms[]": ("arm", "KEYS"),
    "arms[].sensors[]": ("arm", "sensors: [{name: eye, link: flange, position: [0, 0, 0], direction: [0, 0, 1], KEYS}]"),
    "obstacles[].shapes[]": ("obstacle", "{KEYS}"),
    "obstacles[].motion": ("motion", "KEYS"),
    "obstacles[].shapes[] of type sphere": ("obstacle", "{type: sphere, KEYS}"),
    "obstacles[].shapes[] of type capsule": ("obstacle", "{type: capsule, radius: 1, length: 1, KEYS}"),
    "obstacles[].shapes[] of type cylinder": ("obstacle", "{type: cylinder, radius: 1, height: 1, KEYS}"),
    "obstacles[].motion of type waypoints": ("motion", "type: waypoints, poses: [{}, {xyz: [1, 0, 0]}], speed: 1, KEYS"),
    "obstacles[].motion of type circle": ("motion", "type: circle, centre: [9, 9, 9], angular_speed: 1, KEYS"),
    "obstacles[].motion of type sine": ("motion", "type: sine, direction: [1, 0, 0], amplitude: 1, period: 1s, KEYS"),
    "obstacles[].motion of type conveyor": ("motion", "type: conveyor, direction: [1, 0, 0], speed: 1, length: 1, KEYS"),
    "obstacles[].motion of type dynamic": ("motion", "type: dynamic, mass: 1, KEYS"),
}
NUMBER = re.compile(r"(?<![\w`.])[-−]?\d+(?:[.,]\d+)*(?:e[+-]?\d+)? ?(?:ns|us|ms|s|min)?\b")
UNITS = {"ns": 1e-9, "us": 1e-6, "ms": 1e-3, "s": 1.0, "min": 60.0, "": 1.0}


def cell_text(where, key, value, urdf):
    place = PLACES.get(where) or ("arm", f"{where.removeprefix('arms[].')}: {{KEYS}}")
    kind, template = place
    entries = re.sub(rf"(?<![\w]){key}: (?:\[[^]]*\]|[^,}}]+), (?=.*KEYS)", "", template)
    text = entries.replace("KEYS", f"{key}: {value}")
    fields = {"root": "", "arm": "", "obstacles": ""}
    if kind == "root":
        fields["root"] = text + "\n"
    elif kind == "arm":
        fields["arm"] = f"    {text}\n"
    elif kind == "obstacle":
        fields["obstacles"] = f"obstacles: [{{name: thing, shapes: [{text}]}}]\n"
    else:
        fields["obstacles"] = f"obstacles: [{{name: thing, shapes: [{{type: sphere, radius: 0.1}}], motion: {{{text}}}}}]\n"
    return BASE.format(urdf=urdf, **fields)


def numbers(text):
    """Values in a text, durations in seconds."""
    found = set()
    for match in NUMBER.findall(text):
        unit = re.search(r"(ns|us|ms|s|min)?$", match)[0]
        found.add(round(float(match.removesuffix(unit).strip().replace("−", "-").replace(",", "")) * UNITS[unit], 12))
    return found


def range_text(allowed):
    """The range alone, of a cell like "3 numbers, ±100; not all 0"."""
    return re.sub(r"±(\d+)", r"−\1 to \1", re.sub(r"\d+ numbers?|multiple of \d+", "", allowed.split(";")[0]))


def too_low(allowed):
    """A value below any range, of the right kind."""
    if re.search(r"\d ?(?:ms|s)\b", allowed):
        return "-1e30s"
    vector = re.match(r"(\d+) numbers", allowed)
    return "[" + ", ".join(["-1e30"] * int(vector[1])) + "]" if vector else "-1e30"


def agree(own, said):
    """The page's range has the ends of the enforced one, or lies within it where it refers to another key."""
    low, high = min(numbers(said)), max(numbers(said))
    if not all(low <= number <= high for number in numbers(own)):
        return False
    return "`" in own or {low, high} <= numbers(own)


def documented(page):
    """(section, key, allowed) of every row of the tables."""
    where = None
    for line in page.splitlines():
        if heading := re.match(r"## `([^`]+)`", line):
            where = heading[1]
        elif (cells := re.split(r"(?<!\\) \| ", line.strip().strip("|").strip())) and re.match(r"\| `\w+` \|", line):
            if len(cells) >= 4:
                yield where, cells[0].strip("` "), cells[3]


def cell_file_findings(root, binaries, page):
    urdf = root.resolve() / "deploy/cells/urdf/puma560.urdf"
    compared = 0
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "cell.yaml"

        def sentence(where, key, value):
            file.write_text(cell_text(where, key, value, urdf))
            done = subprocess.run([binaries / "hecaton", "check", file], capture_output=True, text=True)
            found = re.search(rf"{re.escape(key)}(?:\[\d+\])? = .*? must be (.*)", done.stderr)
            return found[1].split(":")[-1] if found else None

        for where, key, allowed in documented(page):
            if where in (None, "cell file", "defaults"):
                continue
            own = range_text(allowed)
            choices = re.findall(r"`([^`]+)`", allowed)
            if numbers(own):
                said = sentence(where, key, too_low(allowed))
                if said and "with its unit" in said:
                    said = sentence(where, key, "-1e30s")
                if said is None or not numbers(said):
                    continue
                compared += 1
                if not agree(own, said):
                    yield f"cell-file.md: {where} {key}: the page allows “{allowed}”, hecaton check “{said}”"
            elif len(choices) > 1:
                said = sentence(where, key, "nonsense")
                if said is None:
                    continue
                compared += 1
                for choice in choices:
                    if choice not in said:
                        yield f"cell-file.md: {where} {key}: `{choice}` is not in “{said}”"
    print(f"cell-file.md: {compared} ranges and choices compared")
    if compared < 60:
        yield f"cell-file.md: only {compared} ranges and choices could be compared"


# --- commands in all documents


def options_of(binaries):
    """A function: the options of a program's command, as its --help lists them; None: there is no such command."""
    known = {}

    def find(program, command):
        if (program, command) not in known:
            words = [binaries / program, *([command] if command else []), "--help"]
            done = subprocess.run(words, capture_output=True, text=True)
            known[program, command] = set(re.findall(r"(?<![\w-])--?[a-z][\w-]*", done.stdout)) if done.returncode == 0 else None
        return known[program, command]

    return find


def command_lines(page):
    """Lines of blocks and spans of code that run a program with several options or commands."""
    code = re.findall(r"^ {4}(.*)$|`([^`\n]+)`", page, re.M)
    for line in (block or span for block, span in code):
        for match in re.finditer(r"(?:^|[ /])(hecaton(?:-strategies|-chaos)?) ([^;|#>]*)", line):
            yield match[1], match[2].split()


def command_findings(root, binaries):
    options = options_of(binaries)
    for page in sorted([*root.glob("*.md"), *(root / "docs").rglob("*.md")]):
        for program, words in command_lines(page.read_text()):
            command = words[0] if program != "hecaton-chaos" and words and re.fullmatch(r"[a-z]+", words[0]) else ""
            allowed = options(program, command)
            if allowed is None:
                yield f"{page.relative_to(root)}: there is no command `{program} {command}`"
                continue
            allowed = allowed | options(program, "")
            if len(words) > 1 and command in ("bag", "keystore", "obstacle") and words[1].islower():
                allowed |= options_below(binaries, program, command, words[1])
            for word in words:
                if re.fullmatch(r"--[a-z][\w-]*", word) and word not in allowed:
                    yield f"{page.relative_to(root)}: `{program} {command}` has no option {word}"


def options_below(binaries, *words):
    return set(re.findall(r"(?<![\w-])--[a-z][\w-]*", output(binaries / words[0], *words[1:], "--help")))


# --- all pages


def renewed(page, parts):
    return GENERATED.sub(lambda match: match[1] + parts[match[2]] + match[3], page)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("root", type=pathlib.Path)
    parser.add_argument("bin", type=pathlib.Path)
    parser.add_argument("--write", action="store_true", help="renew the generated parts")
    options = parser.parse_args()
    folder = options.root / "docs/reference"
    findings = []
    for name, parts in (("cli.md", cli_parts(options.bin)), ("topics.md", topics_parts(options.root)),
                        ("robots.md", robots_parts(options.bin)), ("faults.md", causes_part(options.root)),
                        ("ready-cells.md", cells_part(options.root)), ("../README.md", index_part(options.root))):
        page = (folder / name).read_text()
        fresh = renewed(page, parts)
        absent = set(parts) - {match[1] for match in GENERATED.findall(page)}
        findings += [f"{name} has no generated part `{part}`" for part in absent]
        if options.write:
            (folder / name).write_text(fresh)
        elif fresh != page:
            findings.append("\n".join([f"{name} is not what the programs and sources say (--write renews it):",
                                       *list(difflib.unified_diff(page.splitlines(), fresh.splitlines(), lineterm="", n=0))[2:22]]))
    findings += index_findings(options.root)
    findings += command_findings(options.root, options.bin)
    findings += fault_findings(options.root, (folder / "faults.md").read_text())
    findings += cell_file_findings(options.root, options.bin, (folder / "cell-file.md").read_text())
    print("\n".join(findings) or "the reference pages say what the programs and sources do")
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main())
