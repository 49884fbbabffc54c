"""Checks the types of idl/ros2/ros2.idl against those of ROS 2, by their hashes: tests/data/ros2_type_hashes.txt has ROS 2's own.
Checks the hashes of services/ros2_messages/ros2_types.hpp against the types of idl/ros2/ros2.idl.

usage: ros2_type_hashes.py ROOT [--write]

A hash (RIHS01) is the SHA-256 of a description of a type and of the types in its fields: it depends on the order, the names
and the types of all fields. A service has a description of its own, with its request, its response and an event.
"""
import hashlib
import json
import pathlib
import re
import sys

BASIC = {"int8": 2, "uint8": 3, "short": 4, "unsigned short": 5, "long": 6, "unsigned long": 7, "long long": 8,
         "unsigned long long": 9, "float": 10, "double": 11, "boolean": 15, "octet": 16, "string": 17}
NESTED, BOUNDED_STRING, ARRAY, BOUNDED, UNBOUNDED = 1, 21, 48, 96, 144
EVENT_INFO = "service_msgs/msg/ServiceEventInfo"


def field_type(text, array):
    """The type of a field in a type description."""
    kind, capacity = 0, 0
    sequence = re.fullmatch(r"sequence<(.+?)(?:,\s*(\d+))?>", text)
    if sequence:
        text, capacity = sequence[1], int(sequence[2] or 0)
        kind = BOUNDED if sequence[2] else UNBOUNDED
    if array:
        kind, capacity = ARRAY, int(array)
    string = re.fullmatch(r"string<(\d+)>", text)
    if string:
        return {"type_id": BOUNDED_STRING + kind, "capacity": capacity, "string_capacity": int(string[1]), "nested_type_name": ""}
    if text in BASIC:
        return {"type_id": BASIC[text] + kind, "capacity": capacity, "string_capacity": 0, "nested_type_name": ""}
    return {"type_id": NESTED + kind, "capacity": capacity, "string_capacity": 0, "nested_type_name": text.replace("::", "/")}


def read_idl(text):
    """{"package/msg/Type": fields} of an IDL file of ours."""
    types, modules = {}, []
    text = re.sub(r"//.*", "", text)
    token = re.compile(r"module (\w+) \{|struct (\w+) \{([^}]*)\};|\};")
    for match in token.finditer(text):
        if match[1]:
            modules.append(match[1])
        elif match[2]:
            fields = [re.fullmatch(r"(.+?)\s+(\w+?)(?:\[(\d+)\])?", field.strip(), re.S)
                      for field in match[3].split(";") if field.strip()]
            types["/".join([*modules, match[2]])] = [
                {"name": field[2].lstrip("_"), "type": field_type(field[1], field[3])} for field in fields]
        else:
            modules.pop()
    return types


def add_services(types):
    """Adds the services, whose requests and responses the file has, with their events."""
    for name in [name for name in types if name.endswith("_Request")]:
        service = name.removesuffix("_Request")
        nested = {"info": EVENT_INFO, "request": f"{service}_Request", "response": f"{service}_Response"}
        types[f"{service}_Event"] = [
            {"name": field, "type": {"type_id": NESTED + (0 if field == "info" else BOUNDED), "capacity": 0 if field == "info" else 1,
                                     "string_capacity": 0, "nested_type_name": of}} for field, of in nested.items()]
        types[service] = [{"name": f"{part}_message", "type": {"type_id": NESTED, "capacity": 0, "string_capacity": 0,
                                                               "nested_type_name": f"{service}_{part.capitalize()}"}}
                          for part in ("request", "response", "event")]


def type_hash(types, name):
    needed, open_names = set(), [name]
    while open_names:
        for field in types[open_names.pop()]:
            nested = field["type"]["nested_type_name"]
            if nested and nested not in needed:
                needed.add(nested)
                open_names.append(nested)
    description = {"type_description": {"type_name": name, "fields": types[name]},
                   "referenced_type_descriptions": [{"type_name": n, "fields": types[n]} for n in sorted(needed)]}
    return hashlib.sha256(json.dumps(description).encode()).hexdigest()


def all_types(root):
    types = read_idl((root / "idl/ros2/ros2.idl").read_text(encoding="utf-8"))
    types[EVENT_INFO] = [
        {"name": "event_type", "type": field_type("uint8", None)},
        {"name": "stamp", "type": field_type("builtin_interfaces::msg::Time", None)},
        {"name": "client_gid", "type": field_type("uint8", "16")},
        {"name": "sequence_number", "type": field_type("long long", None)}]
    # An empty message has one byte on the wire, and the same field in its description.
    add_services(types)
    return types


def text_field(line):
    """A field of a message text of ROS 2 whose types are in the same package."""
    text, name = line.split()
    base, size = re.fullmatch(r"([\w<=]+)(?:\[(\d*)\])?", text).groups()
    idl = base.replace("string<=", "string<") + (">" if "<=" in base else "")
    if idl not in BASIC and not idl.startswith("string"):
        idl = f"rmw_dds_common::msg::{base}"
    return {"name": name, "type": field_type(f"sequence<{idl}>" if size == "" else idl, size or None)}


def node_names(root):
    """The types of the announcement of nodes, of each distribution under the one name that ROS 2 has for both."""
    texts = root / "tests/cell/interop/ros2/rmw_dds_common"
    return {distribution: {f"rmw_dds_common/msg/{file.stem}": [text_field(line) for line in file.read_text(encoding="utf-8").splitlines()]
                           for file in (texts / folder).glob("*.msg")}
            for distribution, folder in (("humble", "humble"), ("jazzy", "msg"))}


def published_hashes(root):
    """{(distribution or "", type): hash} of the file with ROS 2's own hashes."""
    rows = [line.split() for line in (root / "tests/data/ros2_type_hashes.txt").read_text(encoding="utf-8").splitlines()
            if line and not line.startswith("#")]
    return {(row[2] if len(row) > 2 else "", row[0]): row[1] for row in rows}


def differences(root, types):
    """A sentence for each type of ours that ROS 2 does not have, or has with other fields."""
    published = published_hashes(root)
    ours = {("", name): type_hash(types, name) for name in types}
    for distribution, named in node_names(root).items():
        ours.update({(distribution, name): type_hash(named, name) for name in named})
    for key in sorted(ours.keys() | published.keys()):
        name = " of ".join(filter(None, reversed(key)))
        if key not in published:
            yield f"tests/data/ros2_type_hashes.txt: no hash of {name}; add the one that ROS 2 publishes"
        elif key not in ours:
            yield f"tests/data/ros2_type_hashes.txt: {name} is no type of idl/ros2/ros2.idl or tests/cell/interop/ros2; remove it"
        elif ours[key] != published[key]:
            yield f"{name}: fields differ from those of ROS 2 (hash {ours[key]}, in ROS 2 {published[key]})"


def main():
    root = pathlib.Path(sys.argv[1])
    types = all_types(root)
    if wrong := list(differences(root, types)):
        print(*wrong, sep="\n")
        return 1
    header = root / "services/ros2_messages/ros2_types.hpp"
    row = re.compile(r'("([\w]+/[\w]+/\w+)",\s*")([0-9a-f]*)(")')
    text = header.read_text(encoding="utf-8")
    right = row.sub(lambda match: match[1] + type_hash(types, match[2]) + match[4], text)
    if "--write" in sys.argv:
        header.write_text(right, encoding="utf-8")
    elif right != text:
        print(f"{header}: type hashes differ from idl/ros2/ros2.idl; run this program with --write")
        return 1
    if not row.search(text):
        print(f"{header}: no type hash found")
        return 1
    print("type hashes agree")
    return 0


if __name__ == "__main__":
    sys.exit(main())
