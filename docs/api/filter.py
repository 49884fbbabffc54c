#!/usr/bin/env python3
"""Gives Doxygen a public header or a message definition; prints the text that Doxygen reads.

usage: filter.py FILE

Of a header, the comment at the top describes the file, and functions of one meaning get one sentence. Of an IDL file, annotations go, modules are namespaces, and every
comment documents what stands beside or below it. A field without a comment that common.idl explains gets its sentence.
"""
import pathlib
import re
import sys


DESCRIBE = "Saves or loads each member, so that a recording can be recomputed."


def header_text(text):
    """The comment behind `#pragma once` belongs to the file. Macros go: they are no part of the interface."""
    text = text.replace("#pragma once\n///", "/// \\file\n///", 1)
    text = re.sub(r"^ *#(?:define|undef) (?:.*\\\n)*.*$", lambda found: "\n" * found[0].count("\n"), text, flags=re.M)
    text = re.sub(r"^( *)(void describe\(MemoryArchive& archive\) \{)", rf"\1/** {DESCRIBE} */ \2", text, flags=re.M)
    return re.sub(r"^HECATON_TOPICS\(.*$|^inline constexpr std::array kTopics.*$", "", text, flags=re.M)


def common_fields(folder):
    """{field: sentence}, from the list at the top of common.idl."""
    head = (folder / "common.idl").read_text().split("#ifndef")[0]
    joined = re.sub(r"\n//   +", " ", head)
    return {name: text for names, text in re.findall(r"^// - ([\w, ]+): (.*)$", joined, re.M) for name in names.split(", ")}


def c_plus_plus_of(path):
    fields = common_fields(path.parent)
    lines, depth, in_head = [], 0, True
    for line in path.read_text().splitlines():
        code, mark, comment = line.partition("//")
        comment = comment.strip().replace("@", "\\@")
        code = re.sub(r"@\w+(?:\([^)]*\))? ?", "", code).replace("module ", "namespace ")
        code = code.replace("sequence<", "Sequence<").rstrip()  # Doxygen takes `sequence` for a type definition
        name = re.search(r"(\w+)(?: = \d+)?[;,]?$", code.strip())
        if in_head and not code.strip() and mark:
            lines.append(("/// \\file\n" if not lines else "") + f"/// {comment}")
            continue
        in_head = in_head and not code.strip()
        if mark and code.strip().endswith("{"):
            lines += [f"/// {comment}", code]
        elif mark and code.strip():
            lines.append(f"{code}  ///< {comment}")
        elif mark:
            # Inside of a definition a comment of its own line is a heading.
            lines.append(f"// {comment}" if depth > 2 else f"/// {comment}")
        elif depth > 2 and name and name[1] in fields:
            lines.append(f"{code}  ///< {fields[name[1]]}")
        else:
            lines.append(code)
        depth += code.count("{") - code.count("}")
    return "\n".join(lines)


def main():
    path = pathlib.Path(sys.argv[1])
    print(c_plus_plus_of(path) if path.suffix == ".idl" else header_text(path.read_text()))


if __name__ == "__main__":
    main()
