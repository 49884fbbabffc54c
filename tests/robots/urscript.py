"""Interprets the part of URScript that programs for set-points use. It translates the text to Python generators.

A thread of a program is a generator. It yields a request whenever URScript would let time pass, such as ("servoj", …), and gets the
result of the request back. The owner of the program decides when a request is done.
"""
import re

TOKEN = re.compile(r'\s*(?:(?P<number>\d+\.\d*(?:[eE][+-]?\d+)?|\d+)|(?P<text>"[^"]*")|(?P<word>[A-Za-z_]\w*)'
                   r'|(?P<sign>==|!=|<=|>=|[-+*/%()\[\],<>=]))')
# Functions that let time pass, and the names of their arguments.
REQUESTS = {
    "servoj": ["q", "a", "v", "t", "lookahead_time", "gain"],
    "stopj": ["a"],
    "sync": [],
    "sleep": ["t"],
    "socket_open": ["address", "port", "name"],
    "socket_read_binary_integer": ["number", "name", "timeout"],
    "socket_close": ["name"],
    "textmsg": ["message", "value"],
    "get_actual_joint_positions": [],
    "get_steptime": [],
}
WORDS = {"and": "and", "or": "or", "not": "not", "True": "True", "False": "False"}
MOST_TURNS = 100_000  # of loops without a request: the controller calls this an infinite loop


class ScriptError(Exception):
    """The text is no program, or the program has failed."""


class Expression:
    """Translates one expression. Every operation of URScript here exists in Python with the same meaning."""

    def __init__(self, text, scope):
        self.scope = scope
        self.tokens = []
        position = 0
        text = text.rstrip()
        while position < len(text):
            match = TOKEN.match(text, position)
            if not match:
                raise ScriptError(f"cannot read: {text[position:]}")
            self.tokens.append((match.lastgroup, match.group(match.lastgroup)))
            position = match.end()

    def next(self):
        return self.tokens[0][1] if self.tokens else None

    def take(self, wanted=None):
        if not self.tokens or (wanted and self.tokens[0][1] != wanted):
            raise ScriptError(f"expected {wanted}, found {self.next()}")
        return self.tokens.pop(0)

    def whole(self):
        python = self.any()
        if self.tokens:
            raise ScriptError(f"unexpected {self.next()}")
        return python

    def any(self):
        parts = []
        while self.tokens and self.next() not in (")", "]", ","):
            kind, value = self.tokens[0]
            if kind == "word" and value in WORDS:
                parts.append(self.take()[1])
            elif kind in ("number", "text", "word") or value in ("(", "["):
                parts.append(self.operand())
            else:
                parts.append(self.take()[1])
        return " ".join(parts)

    def operand(self):
        kind, value = self.take()
        if value == "(":
            python = f"({self.any()})"
            self.take(")")
        elif value == "[":
            python = f"[{', '.join(self.list_until(']'))}]"
        elif kind == "word" and self.next() == "(":
            self.take()
            python = self.call(value)
        elif kind == "word":
            python = self.scope.name(value)
        else:
            python = value
        while self.next() == "[":
            self.take()
            python += f"[{self.any()}]"
            self.take("]")
        return python

    def list_until(self, end):
        items = []
        while self.next() != end:
            items.append(self.any())
            if self.next() == ",":
                self.take()
        self.take(end)
        return items

    def call(self, function):
        if function not in REQUESTS:
            raise ScriptError(f"function {function} is not known here")
        names, values = REQUESTS[function], {}
        while self.next() != ")":
            if len(self.tokens) > 1 and self.tokens[0][0] == "word" and self.tokens[1][1] == "=":
                name = self.take()[1]
                self.take("=")
            else:
                name = names[len(values)]
            values[name] = self.any()
            if self.next() == ",":
                self.take()
        self.take(")")
        unknown = set(values) - set(names)
        if unknown:
            raise ScriptError(f"{function} has no argument {unknown}")
        arguments = ", ".join(f'"{name}": {python}' for name, python in values.items())
        return f'(yield ("{function}", {{{arguments}}}))'


class Scope:
    """Where a name of a thread lives: in `G` of the program or in `L` of the thread."""

    def __init__(self, globals_):
        self.globals = globals_

    def name(self, word):
        return f'G["{word}"]' if word in self.globals else f'L["{word}"]'


class Program:
    """A program text. `begin` gives its main thread; a request ("run", name) wants another."""

    def __init__(self, text):
        lines = [re.sub(r"#.*", "", line).strip() for line in text.splitlines()]
        self.lines = [line for line in lines if line]
        self.globals = {match.group(1) for line in self.lines if (match := re.match(r"global (\w+)\s*=", line))}
        self.values = {}
        self.python = []
        match = re.fullmatch(r"def (\w+)\(\):", self.lines[0]) if self.lines else None
        if not match:
            raise ScriptError("the program does not begin with 'def NAME():'")
        self.name = match.group(1)
        self.at = 1
        self.threads = {}
        self.translate("main")
        if self.at != len(self.lines):
            raise ScriptError(f"text after the end: {self.lines[self.at]}")

    def translate(self, name):
        scope = Scope(self.globals)
        body = self.block(scope, 1)
        source = "\n".join([f"def {name}(G, copy, turn):", "    L = {}", "    if False: yield", *body])
        space = {}
        exec(compile(source, f"<{self.name}.{name}>", "exec"), space)
        self.threads[name] = space[name]

    def block(self, scope, depth):
        """Lines until `end`, `else` or `elif`."""
        python, indent = [], "    " * depth
        while self.at < len(self.lines):
            line = self.lines[self.at]
            if line == "else:" or line.startswith("elif "):
                return python or [indent + "pass"]
            self.at += 1
            if line == "end":
                return python or [indent + "pass"]
            if match := re.fullmatch(r"thread (\w+)\(\):", line):
                self.translate(match.group(1))
            elif match := re.fullmatch(r"(if|while) (.*):", line):
                python.append(f"{indent}{match.group(1)} {Expression(match.group(2), scope).whole()}:")
                if match.group(1) == "while":
                    python.append(indent + "    turn()")
                python += self.block(scope, depth + 1)
                if match.group(1) == "if":
                    python += self.alternatives(scope, depth)
            else:
                python.append(indent + self.statement(line, scope))
        raise ScriptError("a block has no end")

    def alternatives(self, scope, depth):
        python, indent = [], "    " * depth
        while self.lines[self.at - 1] != "end":
            line = self.lines[self.at]
            self.at += 1
            if line == "else:":
                python.append(indent + "else:")
            else:
                python.append(f"{indent}elif {Expression(line[5:-1], scope).whole()}:")
            python += self.block(scope, depth + 1)
        return python

    def statement(self, line, scope):
        if line in ("enter_critical", "exit_critical"):
            return "pass"  # only a request interrupts a thread
        if match := re.fullmatch(r"join (\w+)", line):
            return f'yield ("join", {{"thread": {scope.name(match.group(1))}}})'
        match = re.fullmatch(r"(?:global |local )?(\w+)((?:\[.*?\])?)\s*=(?!=)\s*(.*)", line)
        if not match:
            return Expression(line, scope).whole()
        word, index, right = match.groups()
        target = scope.name(word) + (f"[{Expression(index[1:-1], scope).whole()}]" if index else "")
        if run := re.fullmatch(r"run (\w+)\(\)", right):
            return f'{target} = (yield ("run", {{"thread": "{run.group(1)}"}}))'
        return f"{target} = copy({Expression(right, scope).whole()})"

    def begin(self, thread="main"):
        return Thread(self, thread)


class Thread:
    """A running thread. `request` is what it waits for; None after its end."""

    def __init__(self, program, name):
        self.turns = 0
        self.generator = program.threads[name](program.values, self.copy, self.turn)
        self.request = None
        self.go_on(None)

    @staticmethod
    def copy(value):
        return list(value) if isinstance(value, list) else value

    def turn(self):
        self.turns += 1
        if self.turns > MOST_TURNS:
            raise ScriptError("infinite loop")

    def go_on(self, result):
        """Gives the result of the request and runs the thread up to its next request."""
        self.turns = 0
        try:
            self.request = self.generator.send(result)
        except StopIteration:
            self.request = None
        except (KeyError, IndexError, TypeError, ZeroDivisionError) as error:
            self.request = None
            raise ScriptError(f"{type(error).__name__}: {error}") from error
