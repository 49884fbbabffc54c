"""A cell file as maps and lists whose values are texts, as they are written. A number of Hecaton stays a number, and nothing
else becomes one: to other YAML readers "on" and "010" mean something else.

usage: cell_document.py --self-test"""
import sys
import unittest

import yaml  # Debian package python3-yaml


class Quoted(str):
    """A text that stood in quotes."""


class Loader(yaml.SafeLoader):
    yaml_implicit_resolvers = {}


class Dumper(yaml.SafeDumper):
    yaml_implicit_resolvers = {}

    def ignore_aliases(self, data):
        return True


Loader.add_constructor("tag:yaml.org,2002:str",
                       lambda _, node: Quoted(node.value) if node.style in ("'", '"') else node.value)
Dumper.add_representer(Quoted, lambda dumper, text: dumper.represent_scalar("tag:yaml.org,2002:str", text, style='"'))


def read(text):
    """Of bytes, too, which must be UTF-8. Raises yaml.YAMLError."""
    return unshared(yaml.load(text, Loader))


def unshared(value):
    """What stands behind an alias is its own: a change to one place of the file changes no other."""
    if isinstance(value, dict):
        return {key: unshared(entry) for key, entry in value.items()}
    if isinstance(value, list):
        return [unshared(entry) for entry in value]
    return value


def write(document):
    """A text that may stand in any folder if its paths may."""
    return yaml.dump(document, Dumper=Dumper, sort_keys=False, allow_unicode=True, default_flow_style=False, width=1 << 20)


class DocumentTest(unittest.TestCase):
    def test_an_alias_is_a_copy(self):
        document = read("world: &w {host: a, list: [b]}\nsupervision: *w\n")
        document["supervision"]["host"] = "c"
        document["supervision"]["list"].append("d")
        self.assertEqual(document["world"], {"host": "a", "list": ["b"]})

    def test_bytes_are_utf_8(self):
        self.assertEqual(read("name: größe".encode()), {"name": "größe"})
        with self.assertRaises(yaml.YAMLError):
            read("# größe\nname: a".encode("latin-1"))

    def test_quotes_stay(self):
        self.assertEqual(write(read('a: "010"\nb: 010\n')), 'a: "010"\nb: 010\n')


if __name__ == "__main__":
    if sys.argv[1:] != ["--self-test"]:
        sys.exit(__doc__)
    unittest.main(argv=sys.argv[:1])
