"""Checks the measurable part of the project's language in documents (*.md) and in comments of sources.

usage: language.py [--report] ROOT [PATH…]     a PATH is a file or a folder below ROOT; without any, all of ROOT

The rules, each with its limit:
  length   a sentence, a list item or a table cell has at most 40 words
  share    at most 5 % of a file's sentences have more than 25 words; one always may
  word     no word of WORDS, which also says what to write instead
  words    the documents (*.md in ROOT and docs/) have at most MOST_WORDS words; only without a PATH

Code, formulas in blocks, headings and link targets have no length; a span in backquotes is one word. Words are sought
in comments and prose outside of backquotes; names of identifiers are sought inside of them, too. The words of a document
are all that have a letter or a digit, also in tables and headings, outside of blocks of code and generated parts.

It prints one line for each finding (file:line: rule: what to write instead) and exits with 1 when there is one. With
--report it prints a table with a row for each folder, the words of each document, no findings, and exits with 0.
"""
import ast
import collections
import io
import pathlib
import re
import sys
import tokenize

LONGEST, LONG, SHARE = 40, 25, 0.05
MOST_WORDS = 30000
SKIPPED = {"build", ".git", "third_party", "node_modules"}
DOCUMENTS, C_FAMILY = {".md"}, {".cpp", ".hpp", ".idl", ".h"}
# Comments in these begin with "#".
HASH_FAMILY, HASH_NAMES = {".cmake", ".yaml", ".sh", ".service", ".conf"}, {"CMakeLists.txt", "Containerfile", "run", "hook"}

# "who" may follow these: a relative clause about people is plain English. For a component it hides the subject.
PEOPLE = r"(?:users?|people|persons?|engineers?|readers?|operators?|integrators?|authors?|developers?|roboticists?|maintainers?|newcomers?)"
NAMED = "name the component"
# (pattern, what to write instead): in prose, in any case, not in backquotes.
WORDS = [(re.compile(rf"\b{pattern}\b".replace(" ", r"\s+"), re.I), instead) for pattern, instead in [
    (rf"(?P<person>{PEOPLE},? )?who", NAMED),
    (r"who(?:ever|m|mever)", NAMED),
    (r"(?:every|no|some|any)body", NAMED),
    (r"(?:someone|no one|everyone)", NAMED),
    (r"the others", "name the components"),
    (r"(?:is|are|was|were|be|been) told", "name the component that reports, and what"),
    (r"old news", "old states; latency compensation"),
    (r"to and fro", "back and forth"),
    (r"play(?:s|ed)? (?:it |them )?through", "simulate; roll out"),
    (r"stragglers?|straggling", "late samples; late"),
    (r"strangers?", "unknown nodes"),
    (r"life lines?", "exit notifier"),
    (r"farewells?", "announcement of departure"),
    (r"composite plans?", "coupled plan"),
    (r"mandates?", "arm lease"),
    (r"referees?", "contact monitor"),
    (r"rest regions?", "reachable stop set"),
    (r"stands? back", "give way; lower the thread priority"),
    (r"urgency", "thread priority; priority"),
    (r"(?<!dead-)reckoned", "dead-reckoned"),
]]
# Names that were replaced: also in backquotes, exactly as they stand here.
NAMES = {
    "CellWatch": "FaultDetector", "HostWatch": "HostMonitor", "PunctualClock": "StallCompensatedClock",
    "TakeoverPatience": "FailoverBackoff", "PlannerSigns": "PlannerHealth", "PlannerFitness": "PlannerHealth",
    "OrderLegacy": "UnreplicatedOrders", "FaultLegacy": "UnreplicatedFaults", "OwedReplies": "DeferredReplies",
    "kNodeTwice": "duplicate_node", "node_twice": "duplicate_node", "kForgetful": "persistence_failed",
    "put_down_to_us": "local_partition_suspected", "meets_anew": "awaiting_rediscovery",
    "detected_within": "detection_latency_bound", "NewestMandate": "NewestArmLease", "life_line": "exit notifier",
    "kept_file": "atomic_file", "turn_watch": "ProgressWatchdog", "gate_transport": "FilteringTransport",
    "GoalDesk": "GoalManager", "GoalAccount": "GoalSnapshot", "UnsaidStatuses": "UnpublishedResults",
    "by_sight": "sensor_only", "old_news": "latency_compensation", "OwnNews": "OwnArmFeedback",
    "CellNews": "DelayedObservations", "rest_region": "reachable_stop_set", "PlayedCell": "RolloutSimulation",
    "take_aim": "select_target", "held_for": "blocked_duration", "--anew": "--clean",
    "together_after": "coordination.stall_timeout", "route.after": "replanning.stall_timeout",
    "tasks.route": "tasks.pose_sequence", "redraw_after": "resample_after",
    "yielding.patience": "yielding.yield_request_delay",
}
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


def words_of(document):
    """How many words a document has by the rule `words`."""
    prose = re.sub(r"<!-- generated.*?<!-- end -->|```.*?```", "", document, flags=re.S)
    return sum(1 for line in prose.splitlines() if not line.startswith("    ") for word in line.split() if re.search(r"[^\W_]", word))


def is_document(file):
    return file.suffix in DOCUMENTS and (len(file.parts) == 1 or file.parts[0] == "docs")


LIST_ITEM = re.compile(r"\s*(?:[-*+•]|\d+[.)])\s+")


def runs_of_prose(lines, first=1, indented=4):
    """Texts of Markdown, or of a comment that is written like it. lines: of one document or comment; first: the number
    of the first line; indented: blanks that make a block of code or a drawing, behind an empty line or a colon."""
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
        item = LIST_ITEM.match(line)
        if line.startswith(" " * indented) and blank and not in_list and not (item and indented < 4):
            open_run = None  # `blank` stays: the block goes on
            continue
        if bare.startswith("#"):
            open_run, in_list, blank = None, False, True
            continue
        if bare.startswith("|"):
            cells = re.sub(r"(`+).+?\1", lambda found: found[0].replace("|", "¦"), bare.replace("\\|", "¦")).strip("|").split("|")
            runs += [Text(number, cell.strip(), cell=True) for cell in cells if cell.strip()]
            open_run = None
            continue
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
        blank = indented < 4 and bare.endswith(":")
    return runs


def comment_lines(text, suffix):
    """Comments of a source as blocks: (number of the first line, lines without their signs)."""
    if suffix == ".py":
        return python_comments(text)
    mark = "//" if suffix in C_FAMILY else "#"
    if mark == "//":
        # Raw strings are no code: their lines stay, empty.
        text = re.sub(r'R"(\w*)\(.*?\)\1"', lambda found: '""' + "\n" * found[0].count("\n"), text, flags=re.S)
    blocks, previous, in_block = [], None, False
    for number, line in enumerate(text.splitlines(), 1):
        if number == 1 and line.startswith("#!"):
            continue
        if mark == "//" and (in_block or line.lstrip().startswith("/*")):
            body = re.sub(r"^\s*(?:/\*+|\*(?!/))?\s?", "", line).split("*/")[0]
            found = 0, not line.lstrip().startswith("/*"), body
            in_block = "*/" not in line
        else:
            found = comment_of(line, mark)
        if found:
            column, continues, body = found
            if not (continues and previous == (number - 1, column)):
                blocks.append((number, []))
            blocks[-1][1].append(body)
            previous = number, column
    return blocks


def comment_of(line, mark):
    """(column, whether nothing stands before it, text) of the comment in a line of code, or None.

    A mark inside of a string is none. A comment behind code begins a block of its own."""
    for found in re.finditer(r""""(?:\\.|[^"\\])*"|'(?:\\.|[^'\\])'|""" + re.escape(mark) + "+[!<]*", line):
        if found[0][0] not in "\"'":
            return found.start(), not line[:found.start()].strip(), re.sub(r"^ ", "", line[found.end():])
    return None


def python_comments(text):
    blocks = [(node.body[0].lineno, ast.get_docstring(node).splitlines()) for node in ast.walk(ast.parse(text))
              if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)) and ast.get_docstring(node, False)]
    previous = None
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.COMMENT:
            number, column = token.start
            if not (previous == (number - 1, column) and not token.line[:column].strip()):
                blocks.append((number, []))
            blocks[-1][1].append(re.sub(r"^#+ ?", "", token.string))
            previous = number, column
    return blocks


# Of a comment, lines that only tools read.
FOR_TOOLS = re.compile(r"^\s*(?:NOLINT|clang-format (?:on|off)|!|IWYU pragma|-\*- coding:)")


def texts_of(text, suffix):
    if suffix in DOCUMENTS:
        return runs_of_prose(text.splitlines())
    runs = []
    for first, lines in comment_lines(text, suffix):
        prose = ["" if FOR_TOOLS.search(line) else line for line in lines]
        runs += runs_of_prose(prose, first, indented=2)
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
        for rule, instead in WORDS:
            for found in rule.finditer(prose):
                if not found.groupdict().get("person"):
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
    if path.name in HASH_NAMES or path.suffix in HASH_FAMILY:
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


def report_words(words):
    print(f"\nwords of documents, outside of blocks of code and generated parts: {sum(words.values()):,} (limit {MOST_WORDS:,})")
    for file, count in sorted(words.items(), key=lambda item: (-item[1], item[0])):
        print(f"{count:7,} {file}")


def main(arguments):
    wants_report = "--report" in arguments
    arguments = [argument for argument in arguments if argument != "--report"]
    if not arguments or arguments[0].startswith("-"):
        sys.exit("usage: language.py [--report] ROOT [PATH…]")
    root = pathlib.Path(arguments[0]).resolve()
    judged = {file: Judged((root / file).read_text(encoding="utf-8"), kind_of(root / file)) for file in files_below(root, arguments[1:])}
    words = {file: words_of((root / file).read_text(encoding="utf-8")) for file in judged if is_document(file)}
    if wants_report:
        report(judged)
        report_words(words)
        return 0
    findings = [f"{file}:{found.line}: {found.rule}: {found.text}" for file, result in judged.items() for found in result.findings]
    if len(arguments) == 1 and sum(words.values()) > MOST_WORDS:
        findings.append(f"documents: words: {sum(words.values()):,} words in {len(words)} documents (limit {MOST_WORDS:,}): say each thing "
                        "once and link to it, or cut what a help text, a header or an IDL file says; --report has the words of each document")
    print("\n".join(findings) or f"the language of {len(judged)} files holds")
    return 1 if findings or not judged else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
