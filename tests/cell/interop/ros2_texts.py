#!/usr/bin/env python3
"""The message texts of ROS 2 for two decoders that share nothing with Hecaton.

usage: ros2_texts.py TEXTS OWN OUT TYPE...

TEXTS has the `.msg` files of ROS 2, PACKAGE/msg/NAME.msg, each followed by those of the messages that it contains. OWN has
in PACKAGE/FOLDER/NAME.msg what TEXTS lacks, without these. TYPE is PACKAGE/FOLDER/NAME. Writes OUT/ros2.idl, as
rosidl_adapter of ROS 2 translates the texts (for idlc), and OUT/ros2_texts.json with {TYPE: text and those that it contains}
(for decoders of npm).
"""

import json
import pathlib
import re
import sys
import tempfile

from rosidl_adapter.msg import convert_msg_to_idl
from rosidl_adapter.parser import parse_message_string

SEPARATOR = "=" * 80


def bare(message: str) -> str:
    """rosidl_adapter knows no names of messages that ROS 2 itself makes of an action."""
    return message.replace("_", "")


class Texts:
    def __init__(self, folders: list[pathlib.Path]) -> None:
        self.files = {}
        for folder in folders:
            for file in sorted(folder.glob("*/*/*.msg")):
                self.files[file.relative_to(folder).with_suffix("").as_posix()] = file

    def text(self, name: str) -> str:
        return self.files[name].read_text(encoding="utf-8").split(SEPARATOR)[0]

    def contained(self, name: str) -> list[str]:
        """The types of its fields, in the folder of the message itself or in `msg`."""
        package, folder, message = name.split("/")
        types = []
        for field in parse_message_string(package, bare(message), self.text(name)).fields:
            if field.type.is_primitive_type():
                continue
            beside = f"{field.type.pkg_name}/{folder}/{field.type.type}"
            types.append(beside if beside in self.files else f"{field.type.pkg_name}/msg/{field.type.type}")
        return types

    def all_of(self, name: str, before: list[str]) -> list[str]:
        """What the message contains, and then itself, without what is before."""
        found: list[str] = []
        for contained in self.contained(name):
            found += self.all_of(contained, before + found)
        return found if name in before + found else [*found, name]

    def idl(self, name: str) -> str:
        """Without the files that it includes, and without comments, which idlc does not read."""
        package, folder, message = name.split("/")
        with tempfile.TemporaryDirectory() as place:
            path = pathlib.Path(place)
            file = pathlib.Path(f"{bare(message)}.msg")
            (path / file).write_text(self.text(name), encoding="utf-8")
            text = convert_msg_to_idl(path, package, file, path).read_text("iso-8859-1")
        text = text.replace(f"struct {bare(message)} {{", f"struct {message} {{")
        text = re.sub(r'@verbatim \(language="comment", text=\n?(\s*"(\\.|[^"\\])*")+\s*\)', "", text)
        text = re.sub(r"^(#|//).*$", "", text, flags=re.MULTILINE).replace("module msg {", f"module {folder} {{")
        for contained in self.contained(name):
            plain = "{}::msg::{}".format(*contained.split("/")[::2])
            text = re.sub(rf"\b{plain}\b", contained.replace("/", "::"), text)
        return text.strip() + "\n"


def main() -> None:
    texts = Texts([pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])])
    out = pathlib.Path(sys.argv[3])
    idl, messages, written = [], {}, []
    for wanted in sys.argv[4:]:
        more = texts.all_of(wanted, written)
        idl += [texts.idl(name) for name in more]
        written += more
        *contained, _ = texts.all_of(wanted, [])
        sections = [f"{SEPARATOR}\nMSG: {'/'.join(name.split('/')[::2])}\n{texts.text(name)}" for name in contained]
        messages[wanted.replace("/", "::")] = "\n".join([texts.text(wanted), *sections])
    out.mkdir(parents=True, exist_ok=True)
    (out / "ros2.idl").write_text("\n".join(idl), encoding="utf-8")
    (out / "ros2_texts.json").write_text(json.dumps(messages, indent=1), encoding="utf-8")


main()
