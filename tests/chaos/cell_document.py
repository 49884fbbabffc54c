"""A cell file as maps and lists whose values are texts, as they are written: what Hecaton takes for a number stays one, and
nothing else becomes one ("on" and "010" mean something of their own to other readers of YAML)."""
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
    return yaml.load(text, Loader)


def write(document):
    """A text that may stand in any folder if its paths may."""
    return yaml.dump(document, Dumper=Dumper, sort_keys=False, allow_unicode=True, default_flow_style=False, width=1 << 20)
