"""Checks the measurable part of the project's language in documents (*.md) and in comments of sources.

usage: language.py [--report] ROOT [PATH…]     a PATH is a file or a folder below ROOT; without any, all of ROOT

The rules, each with its limit:
  length   a sentence, a list item or a table cell has at most 40 words
  share    at most 5 % of a file's sentences have more than 25 words; one always may
  word     no word of WORDS, which also says what to write instead

Code, formulas in blocks, headings and link targets have no length; a span in backquotes is one word. Words are sought
in comments and prose outside of backquotes; names of identifiers are sought inside of them, too.

It prints one line for each finding (file:line: rule: what to write instead) and exits with 1 when there is one. With
--report it prints a table with a row for each folder, no findings, and exits with 0.
"""
import ast
import collections
import io
import pathlib
import re
import sys
import tokenize

LONGEST, LONG, SHARE = 40, 25, 0.05
SKIPPED = {"build", ".git", "third_party"}
DOCUMENTS, C_FAMILY, HASHED = {".md"}, {".cpp", ".hpp", ".idl", ".h"}, {".cmake", ".txt"}

PEOPLE = (r"(?:users?|people|persons?|engineers?|readers?|operators?|integrators?|authors?|developers?|roboticists?|maintainers?"
          r"|newcomers?|anyone|those)")
NAMED = "name the component"
# (pattern, what to write instead); prose only, any case.
WORDS = [
    (rf"(?<!{PEOPLE[3:-1].split('|')[0]})\bwho(?:'s)?\b", NAMED),
    (r"\bwho(?:ever|m|mever)\b", NAMED),
    (r"\b(?:every|no|some|any)body\b", NAMED),
    (r"\b(?:someone|no one|everyone)\b", NAMED),
    (r"\bthe others\b", NAMED + "s"),
    (r"\b(?:is|are|was|were|be|been) told\b", "name the component that reports, and what"),
    (r"\bold news\b", "old states, latency compensation"),
    (r"\bto and fro\b", "back and forth"),
    (r"\b(?:by sight)\b", "sensor_only"),
    (r"\bplay(?:s|ed)? (?:it |them )?through\b", "simulate, roll out"),
    (r"\bstragglers?\b", "late samples"),
    (r"\bstraggling\b", "late"),
    (r"\bstrangers?\b", "unknown nodes"),
    (r"\blife lines?\b", "exit notifier"),
    (r"\bfarewells?\b", "announcement of departure"),
    (r"\bcomposite plans?\b", "coupled plan"),
    (r"\bmandates?\b", "arm lease"),
    (r"\breferees?\b", "contact monitor"),
    (r"\brest regions?\b", "reachable stop set"),
    (r"\bstands? back\b", "raise or lower the thread priority; give way"),
    (r"\bput down to\b", "attribute to"),
    (r"\b(?<!dead-)reckoned\b", "dead-reckoned"),
]
# Names that were replaced; also in backquotes, exactly as they stand here.
NAMES = {
    "CellWatch": "FaultDetector", "HostWatch": "HostMonitor", "PunctualClock": "StallCompensatedClock",
    "TakeoverPatience": "FailoverBackoff", "PlannerSigns": "PlannerHealth", "PlannerFitness": "PlannerHealth",
    "OrderLegacy": "UnreplicatedOrders", "FaultLegacy": "UnreplicatedFaults", "OwedReplies": "DeferredReplies",
    "kNodeTwice": "duplicate_node", "node_twice": "duplicate_node", "kForgetful": "persistence_failed",
    "put_down_to_us": "local_partition_suspected", "meets_anew": "awaiting_rediscovery",
    "detected_within": "detection_latency_bound", "NewestMandate": "NewestArmLease", "life_line": "exit notifier",
    "kept_file": "atomic file", "turn_watch": "ProgressWatchdog", "gate_transport": "FilteringTransport",
    "GoalDesk": "GoalManager", "GoalAccount": "GoalSnapshot", "UnsaidStatuses": "a part of failover",
    "by_sight": "sensor_only", "old_news": "latency compensation", "OwnNews": "OwnArmFeedback",
    "CellNews": "DelayedObservations", "rest_region": "reachable stop set", "PlayedCell": "RolloutSimulation",
    "take_aim": "select_target", "held_for": "blocked_duration", "--anew": "--clean", "together_after": "coordination.stall_timeout",
    "route.after": "replanning.stall_timeout", "tasks.route": "tasks.pose_sequence", "redraw_after": "resample_after",
    "yielding.patience": "yielding.yield_request_delay",
}
WHO = re.compile(rf"(?:\b{PEOPLE},?\s+)?\bwho\b(?!\w)", re.I)
RULES = [(re.compile(pattern, re.I), instead) for pattern, instead in WORDS[1:]]
NAME = re.compile("|".join(rf"(?<![\w-]){re.escape(name)}(?!\w)" for name in NAMES))

ABBREVIATIONS = re.compile(r"\b(e\.g|i\.e|etc|vs|cf|al|eq|eqs|fig|figs|no|sec|p|pp|St|approx)\.(?=\s)", re.I)
SENTENCE = re.compile(r"(?<=[.!?])[\"')\]*_]*\s+(?=[\"'(\[*_]*[A-Z0-9`…ÄÖÜ\x01])|(?<=[.!?])[\"')\]*_]*\s+(?=\x01)")
CODE = "\x01"  # stands for a span in backquotes

Finding = collections.namedtuple("Finding", "line rule text")


class Text:
    """A run of prose: a paragraph, a list item or a table cell, with the line on which it begins."""

    def __init__(self, line, text, cell=False):
        self.line, self.text, self.cell = line, text, cell


def words_in(sentence):
    return sum(1 for token in sentence.split() if re.search(r"[^\W_]|\x01", token))


def sentences(text):
    """Of prose without code: (offset of the first character, sentence)."""
    prose = ABBREVIATIONS.sub(lambda found: found[0][:-1] + "·", text)
    begin = 0
    for gap in [*SENTENCE.finditer(prose), None]:
        end = gap.start() if gap else len(prose)
        if prose[begin:end].strip():
            yield begin + len(prose[begin:end]) - len(prose[begin:end].lstrip()), prose[begin:end].strip()
        begin = gap.end() if gap else end


def without_markup(text):
    """Prose of the same number of lines: code becomes one sign, links their text, emphasis nothing."""
    text = re.sub(r"(`+)(.+?)\1", lambda found: CODE + "\n" * found[0].count("\n"), text, flags=re.S)
    text = re.sub(r"<!--.*?-->", lambda found: "\n" * found[0].count("\n"), text, flags=re.S)
    text = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", text)
    return re.sub(r"\*\*|__", "", text)


LIST_ITEM = re.compile(r"\s*(?:[-*+•]|\d+[.)]|\|)\s+")
INDENTED = re.compile(r" {4,}\S")


def runs_of_prose(lines, first=1):
    """Texts of Markdown, or of a comment that is written like it. lines: of one document or comment, first: its number."""
    runs, open_run, fenced, in_list, blank = [], None, False, False, True
    for number, line in enumerate(lines, first):
        bare = line.strip()
        if bare.startswith("```"):
            fenced, open_run = not fenced, None
            continue
        if fenced:
            continue
        if not bare or re.fullmatch(r"[-=*_~|:+ /#]+", bare):
            blank, open_run = True, None
            continue
        if INDENTED.match(line) and blank and not in_list:
            continue  # a block of code; blank lines do not end it
        if bare.startswith("#"):
            open_run, in_list, blank = None, False, True
            continue
        if bare.startswith("|"):
            cells = re.sub(r"(`+).+?\1", lambda found: found[0].replace("|", "¦"), bare.replace("\\|", "¦")).strip("|").split("|")
            runs += [Text(number, cell.strip(), cell=True) for cell in cells if cell.strip()]
            open_run = None
            continue
        item = LIST_ITEM.match(line)
        if item:
            in_list = True
            open_run = Text(number, line[item.end():])
            runs.append(open_run)
        elif open_run is None:
            in_list = in_list and line.startswith(" ")
            open_run = Text(number, bare)
            runs.append(open_run)
        else:
            open_run.text += "\n" + bare
        blank = False
    return runs


def comment_lines(text, suffix):
    """Comments of a source as blocks: (number of the first line, lines without their signs)."""
    if suffix == ".py":
        yield from python_comments(text)
        return
    mark = "#" if suffix in HASHED else "//"
    block, last = [], None
    in_block = False
    for number, line in enumerate(text.splitlines(), 1):
        if mark == "//" and (in_block or line.lstrip().startswith("/*")):
            body = re.sub(r"^\s*(?:/\*+|\*(?!/))?\s?", "", line)
            in_block = "*/" not in line
            found = (0, body.split("*/")[0])
        else:
            found = comment_of(line, mark)
        if found and block and last == number - 1 and found[0] == column:
            block.append(found[1])
        else:
            if block:
                yield last - len(block) + 1, block
            block = [found[1]] if found else []
        column, last = (found[0] if found else None), number
        if not found:
            block = []
    if block:
        yield last - len(block) + 1, block


def comment_of(line, mark):
    """(column, text) of the comment in a line of code, or None. A mark inside of a string is none."""
    position = -1
    for found in re.finditer(r'"(?:\\.|[^"\\])*"|' + re.escape(mark) + "+[!<]*", line):
        if not found[0].startswith('"'):
            position, end = found.start(), found.end()
            break
    if position < 0:
        return None
    alone = not line[:position].strip()
    return (position if alone else position + 1000), re.sub(r"^ ", "", line[end:])


def python_comments(text):
    lines = {}
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.COMMENT:
            lines[token.start[0]] = (token.start[1], token.string.lstrip("#")[1:])
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)) and ast.get_docstring(node, False):
            yield node.body[0].lineno, ast.get_docstring(node).splitlines()
    block, previous = [], None
    for number, (column, body) in sorted(lines.items()):
        if block and (number, column) != (previous[0] + 1, previous[1]):
            yield previous[0] - len(block) + 1, block
            block = []
        block.append(body)
        previous = number, column
    if block:
        yield previous[0] - len(block) + 1, block


def texts_of(text, suffix):
    if suffix in DOCUMENTS:
        return runs_of_prose(text.splitlines())
    runs = []
    for first, lines in comment_lines(text, suffix):
        if not any(re.search(r"NOLINT|clang-format|^!|IWYU|coding:", line) for line in lines):
            runs += runs_of_prose(lines, first)
    return runs


class Judged:
    """What a file is made of: findings, and the lengths of its sentences."""

    def __init__(self, text, suffix):
        self.findings, self.lengths = [], []
        long = []
        for run in texts_of(text, suffix):
            prose = without_markup(run.text)
            self._check_words(run, prose)
            for offset, sentence in sentences(prose):
                length, line = words_in(sentence), run.line + prose[:offset].count("\n")
                if length < 3:
                    continue
                if length > LONGEST:
                    what = "cell" if run.cell else "sentence"
                    self._find(line, "length", f"{length} words in a {what} (limit {LONGEST}): divide it: {short(sentence)}")
                if not run.cell:
                    self.lengths.append(length)
                    if length > LONG:
                        long.append((length, line, sentence))
        allowed = max(1, int(SHARE * len(self.lengths)))
        if len(long) > allowed:
            for length, line, sentence in long:
                self._find(line, "share", f"{length} words; {len(long)} of {len(self.lengths)} sentences of this file have more than "
                           f"{LONG} (at most {allowed} may): shorten it: {short(sentence)}")
        self.findings.sort()
        self.long = len(long)

    def _find(self, line, rule, text):
        self.findings.append(Finding(line, rule, text))

    def _check_words(self, run, prose):
        for found in WHO.finditer(prose):
            if not re.match(PEOPLE, found[0], re.I):
                self._word(run, prose, found, NAMED)
        for rule, instead in RULES:
            for found in rule.finditer(prose):
                self._word(run, prose, found, instead)
        for found in NAME.finditer(run.text):
            self._word(run, run.text, found, NAMES[found[0]])

    def _word(self, run, text, found, instead):
        word = " ".join(found[0].split())
        self._find(run.line + text[:found.start()].count("\n"), "word", f"“{word}”; write instead: {instead}")


def short(sentence):
    flat = " ".join(sentence.replace(CODE, "`…`").split())
    return flat if len(flat) < 70 else flat[:67] + "…"


def kind_of(path):
    if path.name == "CMakeLists.txt" or path.suffix == ".cmake":
        return ".cmake"
    return path.suffix if path.suffix in DOCUMENTS | C_FAMILY | {".py"} else None


def files_below(root, names):
    for place in ([root / name for name in names] or [root]):
        if not place.exists():
            sys.exit(f"language.py: {place}: there is no such file; give paths below {root}")
        for file in sorted(place.rglob("*")) if place.is_dir() else [place]:
            inside = file.relative_to(root)
            # This file and its test quote what they forbid.
            if file.is_file() and kind_of(file) and not SKIPPED & set(inside.parts) and file.name not in ("language.py", "test_language.py"):
                yield inside


def report(judged):
    """A row for each folder, documents and sources apart; words are those of sentences, not of tables."""
    rows = collections.defaultdict(lambda: [0] * 6)
    for file, found in judged.items():
        folder = "/".join(file.parts[:-1][:2]) or "."
        for name in (f"{folder} ({'documents' if file.suffix in DOCUMENTS else 'comments'})", "all"):
            row = rows[name]
            rules = collections.Counter(finding.rule for finding in found.findings)
            for column, value in enumerate((len(found.lengths), sum(found.lengths), found.long, rules["length"], rules["word"])):
                row[column] += value
            row[5] = max(row[5], *found.lengths, 0)
    print(f"{'folder':44} sentences  words  over {LONG}  share  longest  over {LONGEST}  words to replace")
    for name in sorted(rows, key=lambda name: (name == "all", name)):
        count, total, long, over, word, longest = rows[name]
        print(f"{name:44} {count:9} {total:6} {long:8} {100 * long / max(count, 1):5.1f}% {longest:8} {over:8} {word:6}")


def main(arguments):
    wants_report = "--report" in arguments
    arguments = [argument for argument in arguments if argument != "--report"]
    if not arguments or arguments[0].startswith("-"):
        sys.exit("usage: language.py [--report] ROOT [PATH…]")
    root = pathlib.Path(arguments[0]).resolve()
    judged = {file: Judged((root / file).read_text(encoding="utf-8"), kind_of(root / file)) for file in files_below(root, arguments[1:])}
    if wants_report:
        report(judged)
        return 0
    findings = [f"{file}:{found.line}: {found.rule}: {found.text}" for file, result in judged.items() for found in result.findings]
    print("\n".join(findings) or f"the language of {len(judged)} files holds")
    return 1 if findings or not judged else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
